//! Straight-line fits through measured sizes.

/// Smallest assumed standard deviation of a reading, mm: a calliper shows hundredths, and their rounding spreads by
/// 0.01 mm / sqrt(12).
const READING_SIGMA_MM: f64 = 0.003;

/// Linear model `measured = gain * nominal + offset`, fitted by least squares.
///
/// ```
/// use fabkit_designs::profile::LinearFit;
/// // Holes that come out 0.2 mm too narrow.
/// let fit = LinearFit::fit(&[(2.0, 1.8), (5.0, 4.8), (12.0, 11.8)]).ok_or("no line")?;
/// assert!((fit.gain - 1.0).abs() < 1e-9 && (fit.offset_mm + 0.2).abs() < 1e-9);
/// assert!((fit.residual_mm((8.0, 7.9)) - 0.1).abs() < 1e-9);
/// assert_eq!(LinearFit::fit(&[(2.0, 1.8), (2.0, 1.9)]), None);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearFit {
    /// Offset, mm.
    pub offset_mm: f64,
    /// Gain.
    pub gain: f64,
    /// Standard deviation of the offset, mm.
    pub sigma_offset_mm: f64,
    /// Standard deviation of the gain.
    pub sigma_gain: f64,
    /// Number of sizes that the line was fitted to.
    pub count: usize,
}

impl LinearFit {
    /// Fits the line through (nominal, measured) sizes, mm; `None` for fewer than two distinct nominal sizes.
    ///
    /// Standard deviations are those of ordinary least squares (Draper and Smith, "Applied Regression Analysis", 1998,
    /// section 1.4), from the scatter of the points about the line but at least from the rounding of a calliper.
    pub fn fit(points: &[(f64, f64)]) -> Option<Self> {
        let count = points.len() as f64;
        let mean = |value: fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / count;
        let (mean_x, mean_y) = (mean(|p| p.0), mean(|p| p.1));
        let spread: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
        if points.len() < 2 || spread < 1e-9 {
            return None;
        }
        let common: f64 = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
        let gain = common / spread;
        let offset_mm = mean_y - gain * mean_x;
        let squares: f64 = points.iter().map(|(x, y)| (y - gain * x - offset_mm).powi(2)).sum();
        // Two points define the line exactly: then only the rounding of the calliper is known.
        let free = count - 2.0;
        let scatter = if free > 0.0 { (squares / free).sqrt() } else { 0.0 };
        let sigma = scatter.max(READING_SIGMA_MM);
        Some(Self {
            offset_mm,
            gain,
            sigma_offset_mm: sigma * (1.0 / count + mean_x.powi(2) / spread).sqrt(),
            sigma_gain: sigma / spread.sqrt(),
            count: points.len(),
        })
    }

    /// Returns the distance of a measured size above the line, mm.
    pub fn residual_mm(&self, (nominal_mm, measured_mm): (f64, f64)) -> f64 {
        measured_mm - self.gain * nominal_mm - self.offset_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_exactly_and_its_error_follows_the_scatter() {
        let line = |x: f64| (x, 0.996 * x - 0.2);
        let fit = LinearFit::fit(&[2.0, 3.0, 5.0, 12.0].map(line)).unwrap();
        assert!((fit.gain - 0.996).abs() < 1e-12 && (fit.offset_mm + 0.2).abs() < 1e-12);
        // Points of +-d about a line through x = -1, 1, -1, 1: gain's sigma is d sqrt(4/2) / 2.
        let fit = LinearFit::fit(&[(-1.0, 0.1), (1.0, 0.1), (-1.0, -0.1), (1.0, -0.1)]).unwrap();
        assert!((fit.sigma_gain - 0.1 * 2f64.sqrt() / 2.0).abs() < 1e-12, "{fit:?}");
        assert!((fit.sigma_offset_mm - fit.sigma_gain).abs() < 1e-12);
        assert_eq!(LinearFit::fit(&[(2.0, 1.0), (2.0, 1.1)]), None);
        assert_eq!(LinearFit::fit(&[]), None);
    }
}
