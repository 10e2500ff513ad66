"""Another value for a parameter, inside the limits that `fabkit show --json` states.

Limits are text for people and programs alike: `8 mm to 60 mm`, `3 to 12`, `true or false`,
`straight, grid, radial`, `1 to 80 characters`, `1 to 3 items, each 2 mm to 40 mm`.
"""

import math
import re

NUMBER = r"-?[\d.]+(?:e-?\d+)?"
RANGE = re.compile(rf"^({NUMBER})( ?[^\d\s.]+)? to ({NUMBER})( ?[^\d\s.]+)?$")
ITEMS = re.compile(r"^(\d+) to (\d+) items, each (.*)$")
CHARACTERS = re.compile(r"characters$")


def moved(rng, limits, value):
    """A value as it is written on the command line; `None` for text, which moves nothing."""
    if CHARACTERS.search(limits):
        return None
    if limits == "true or false":
        return "false" if value == "true" else "true"
    items = ITEMS.match(limits)
    if items:
        return moved_list(rng, int(items[1]), int(items[2]), items[3], value)
    numbers = RANGE.match(limits)
    if numbers:
        return moved_number(rng, numbers, value)
    return rng.choice(limits.split(", "))


def moved_list(rng, fewest, most, limits, value):
    items = [item.strip() for item in value.strip("[]").split(",") if item.strip()]
    how = rng.random()
    if how < 0.25 and len(items) > fewest:
        items.pop(rng.randrange(len(items)))
    elif how < 0.45 and len(items) < most:
        items.append(moved(rng, limits, items[-1]))
    else:
        for i in range(len(items)):
            if rng.random() < 0.4:
                items[i] = moved(rng, limits, items[i])
    if RANGE.match(limits) and rng.random() < 0.8:
        # Lists must grow mostly.
        items.sort(key=lambda item: float(re.match(NUMBER, item)[0]))
    else:
        items = list(dict.fromkeys(items))
    return f"[{', '.join(items)}]"


def moved_number(rng, numbers, value):
    low, high, unit = float(numbers[1]), float(numbers[3]), (numbers[4] or "").strip()
    now = float(re.match(NUMBER, value)[0])
    is_whole = not unit and "." not in numbers[1] + numbers[3] and "." not in value
    how = rng.random()
    if how < 0.4:
        new = now * (1 + rng.gauss(0, 0.1)) if now else rng.uniform(0, 0.1 * (high - low))
    elif how < 0.7:
        new = (now or 0.05 * (high - low)) * math.exp(rng.uniform(-1, 1))
    elif how < 0.85:
        new = rng.uniform(low, high)
    elif how < 0.93:
        new = now + rng.choice((-2, -1, -0.5, 0.5, 1, 2))
    else:
        new = rng.choice((low, high))
    new = min(max(new, low), high)
    if is_whole:
        whole = round(new)
        if whole == round(now):
            whole += rng.choice((-1, 1))
        return str(int(min(max(whole, low), high)))
    # Round values meet each other, crooked ones nearly do.
    digits = rng.choice((0, 1, 1, 2, 6))
    rounded = min(max(round(new, digits), low), high)
    return f"{rounded:.6g}{' ' + unit if unit else ''}"
