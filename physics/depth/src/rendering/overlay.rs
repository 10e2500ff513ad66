//! Lines and rectangles drawn over a finished image.

use super::RenderedImage;

impl RenderedImage {
    /// Creates an image of one colour.
    ///
    /// # Errors
    /// An image without pixels, or a too large one.
    pub fn filled(
        width_px: u32,
        height_px: u32,
        color: [u8; 3],
    ) -> Result<Self, super::RenderError> {
        Self::blank(width_px, height_px, color)
    }

    /// Draws a polyline with round ends over the image; parts outside are clipped.
    ///
    /// ```
    /// use fabkit_depth::RenderedImage;
    ///
    /// // A red line, 3 px wide, along the middle of the fourth row, whose centre is at 3.5.
    /// let mut image = RenderedImage::filled(9, 7, [255; 3])?;
    /// image.draw_line(&[[0.0, 3.5], [9.0, 3.5]], 3.0, [255, 0, 0]);
    /// assert_eq!((image.pixel(4, 3), image.pixel(4, 0)), ([255, 0, 0], [255; 3]));
    /// # Ok::<(), fabkit_depth::RenderError>(())
    /// ```
    pub fn draw_line(&mut self, points_px: &[[f64; 2]], width_px: f64, color: [u8; 3]) {
        for ends in points_px.windows(2) {
            self.draw_piece(ends[0], ends[1], width_px, color);
        }
    }

    /// Fills a rectangle from its left top corner to its right bottom one, px; parts outside are clipped.
    pub fn fill(&mut self, [left, top]: [i64; 2], [right, bottom]: [i64; 2], color: [u8; 3]) {
        for row in top.max(0)..bottom.min(i64::from(self.height_px)) {
            for column in left.max(0)..right.min(i64::from(self.width_px)) {
                self.mix([column as u32, row as u32], color, 1.0);
            }
        }
    }

    /// Draws a straight line with round ends.
    fn draw_piece(&mut self, from: [f64; 2], to: [f64; 2], width_px: f64, color: [u8; 3]) {
        let Some([from, to]) = self.clip_line(from, to, width_px + 1.0) else { return };
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let length_squared = dx * dx + dy * dy;
        let reach = 0.5 * width_px + 1.0;
        let range = |a: f64, b: f64, most: u32| {
            let low = (a.min(b) - reach).floor().max(0.0) as u32;
            low..((a.max(b) + reach).ceil().max(0.0) as u32).min(most)
        };
        for row in range(from[1], to[1], self.height_px) {
            for column in range(from[0], to[0], self.width_px) {
                let [x, y] = [f64::from(column) + 0.5 - from[0], f64::from(row) + 0.5 - from[1]];
                let along = if length_squared > 0.0 {
                    ((x * dx + y * dy) / length_squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let away = (x - along * dx).hypot(y - along * dy);
                // Coverage of a pixel by the line, by the distance of its centre: antialiasing.
                let covers = (0.5 * width_px + 0.5 - away).clamp(0.0, 1.0);
                if covers > 0.0 {
                    self.mix([column, row], color, covers);
                }
            }
        }
    }

    /// Clips a line to the image with a margin around it.
    fn clip_line(&self, from: [f64; 2], to: [f64; 2], margin: f64) -> Option<[[f64; 2]; 2]> {
        let (mut start, mut end) = (0.0f64, 1.0f64);
        for (axis, size_px) in [self.width_px, self.height_px].into_iter().enumerate() {
            let d = to[axis] - from[axis];
            // Parameters of the line where it enters and leaves the image along this axis.
            let (low, high) = (-margin - from[axis], f64::from(size_px) + margin - from[axis]);
            if d == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            start = start.max((low / d).min(high / d));
            end = end.min((low / d).max(high / d));
        }
        let at = |share: f64| [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        (start <= end).then(|| [at(start), at(end)])
    }

    /// Blends a colour into a pixel.
    fn mix(&mut self, [column, row]: [u32; 2], color: [u8; 3], weight: f64) {
        let at = 3 * (row as usize * self.width_px as usize + column as usize);
        for (channel, new) in self.rgb[at..at + 3].iter_mut().zip(color) {
            let old = f64::from(*channel);
            *channel = (old + weight * (f64::from(new) - old)).round() as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_where_they_are_drawn_and_nowhere_else() {
        let mut image = RenderedImage::filled(20, 10, [255; 3]).unwrap();
        image.draw_line(&[[-1e9, 5.0], [1e9, 5.0]], 2.0, [0; 3]);
        for column in 0..20 {
            let rows: Vec<u8> = (0..10).map(|row| image.pixel(column, row)[0]).collect();
            assert_eq!(rows, [255, 255, 255, 255, 0, 0, 255, 255, 255, 255]);
        }
        let before = image.clone();
        image.draw_line(&[[0.0, -50.0], [20.0, -50.0]], 2.0, [0; 3]);
        image.fill([30, 0], [40, 10], [0; 3]);
        assert_eq!(image, before);
        image.fill([-5, 0], [1, 2], [9; 3]);
        assert_eq!((image.pixel(0, 1), image.pixel(0, 2)), ([9; 3], [255; 3]));
    }
}
