"""A gymnasium environment around `fabkit.sim.Sensor`: find with a ball, by pictures alone, how deep it presses.

    pip install fabkit gymnasium
    python gymnasium_touch.py
"""

import gymnasium
import numpy as np
from gymnasium import spaces

import fabkit.sim

BALL_MM = 4.0
DEEPEST_MM = 0.8
STEP_MM = 0.1


class Touch(gymnasium.Env):
    """Each step presses anew at a depth that the action changes, mm; the reward is minus how far it is from the one that is wanted."""

    def __init__(self, sensor="rtac0", size_px=(80, 60)):
        self.sensor = fabkit.sim.Sensor(sensor, size_px=size_px, spacing_mm=0.8)
        self.tip = self.sensor.sensor_from_touch[:3, 3]
        self.action_space = spaces.Box(-STEP_MM, STEP_MM, (1,), dtype=np.float32)
        self.observation_space = spaces.Box(0, 255, self._felt(0.0).image.shape, dtype=np.uint8)

    def _felt(self, depth_mm):
        ball = fabkit.sim.ball(BALL_MM).at(*np.add(self.tip, [0, 0, BALL_MM - depth_mm]))
        return self.sensor.press(ball, seed=int(self.np_random.integers(2**31)))

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.depth_mm = self.np_random.uniform(0, DEEPEST_MM)
        self.wanted_mm = self.np_random.uniform(0, DEEPEST_MM)
        return self._felt(self.depth_mm).image, {"wanted_mm": self.wanted_mm}

    def step(self, action):
        self.depth_mm = float(np.clip(self.depth_mm + action[0], 0, DEEPEST_MM))
        felt = self._felt(self.depth_mm)
        off_mm = abs(self.depth_mm - self.wanted_mm)
        told = {"force_n": felt.force_n, "deepest_mm": felt.deepest_mm, "wanted_mm": self.wanted_mm}
        return felt.image, -off_mm, off_mm < STEP_MM / 2, False, told


if __name__ == "__main__":
    touch = Touch()
    _, told = touch.reset(seed=1)
    for count in range(1, 101):
        _, reward, done, _, told = touch.step(np.sign([told["wanted_mm"] - touch.depth_mm]) * STEP_MM)
        if done:
            break
    print(f"{count} steps, {-reward:.3f} mm off, {-told['force_n'][2]:.3f} N")
