//! Properties of a purchasable article.

use fabkit_geometry::{Angle, Length};

use super::PackSize;
use crate::materials::{Current, Euros, Kelvin, Voltage, Wavelength};
use crate::parameters::{choices, parameters};

choices! {
    /// Reason for buying an article.
    pub enum ArticleRole {
        /// Piece of the sensor or of its tools, or component of a mix.
        Piece = "piece",
        /// Stock from which parts are made.
        Stock = "stock",
        /// Supply that is used up by the work.
        Supply = "supply",
        /// Tool that is used again.
        Tool = "tool",
    }
}

parameters! {
    /// Article that is bought. Unknown data are left out.
    pub struct Article {
        /// Role of the article: `piece` of the sensor, of its tools or of a mix; `stock` for parts; `supply` that is
        /// used up; or `tool`. A `piece` if not given.
        role: Option<ArticleRole>,
        /// Properties to look for when the article has no order number.
        what: Option<String> = 1..=300,
        /// Maker of the article.
        maker: Option<String> = 1..=100,
        /// Maker's name or number of the article.
        number: Option<String> = 1..=100,
        /// Standard to which the article conforms.
        standard: Option<String> = 1..=60,
        /// Quantity in one pack.
        pack: Option<PackSize>,
        /// Price of a pack, or of the kit.
        price: Option<Euros> = 0.01..=100000.0,
        /// Name of the kit with which the article is sold. The kit is paid for once.
        kit: Option<String> = 1..=100,
        /// Articles that may be bought instead.
        substitutes: Option<String> = 1..=300,
        /// Words, separated by semicolons, by which the article is found: supplies and tools by words of the chain's
        /// steps, stock by names of materials.
        words: Option<String> = 1..=200,
        /// Process for which the article is stock.
        process: Option<String> = 1..=20,
        /// Length of a stock sheet.
        length: Option<Length> = 1.0..=10000.0,
        /// Width of a stock sheet.
        width: Option<Length> = 1.0..=10000.0,
        /// Forward voltage of an LED.
        forward_voltage: Option<Voltage> = 0.5..=60.0,
        /// Rated current of an LED.
        current: Option<Current> = 0.1..=5000.0,
        /// Dominant wavelength of an LED, or its peak wavelength if its light is invisible.
        wavelength: Option<Wavelength> = 200.0..=2000.0,
        /// Colour temperature of a white LED.
        color_temperature: Option<Kelvin> = 1000.0..=20000.0,
        /// Full angle at which an LED's intensity has fallen to half.
        view_angle: Option<Angle> = 1.0..=180.0,
        /// Source of these data.
        source: Option<String> = 1..=300,
        /// Source of the price.
        price_source: Option<String> = 1..=200,
    }
}
