//! Depth networks given as ONNX, evaluated where something touches.
//!
//! A network of a tactile sensor is small: some convolutions, and what is done to each number between them. That much
//! of ONNX is read here ([`Network::read`]), and everything else is refused by the name of its node. Nothing here knows
//! sensors, cameras, or what a number of the picture means.
//!
//! # Conventions
//!
//! - `f32`, row by row. A picture has one channel; what comes out has one, and as many rows and columns.
//! - Maps keep their size: strides and dilations are 1, and paddings half of each window, with zeros.
//! - Same network and picture, same bits, on any number of threads and in registers of any width: each number is one
//!   sum in a fixed order, of multiplications and additions that round once.
//!
//! Where nothing touches, the difference to the picture at rest is zero, and depth networks are not trained there: their
//! authors take zero for what comes out (R-Tac0). [`Network::run_touched`] leaves such places out, tile by tile, and
//! gives elsewhere what [`Network::run`] gives, to the bit.
//!
//! ```
//! use fabkit_network::Network;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // y = relu(2 x), as an ONNX file: one node of kind Conv, one Relu.
//! let file = fabkit_network::writing::chain(&[
//!     fabkit_network::writing::Layer::convolution([1, 1, 1, 1], 1, &[2.0], &[0.0]),
//!     fabkit_network::writing::Layer::operator("Relu"),
//! ]);
//! let network = Network::read(&file)?;
//! let depth = network.run(&[0.5, -1.0, 0.0, 1.5], 2)?;
//! assert_eq!(depth, [1.0, 0.0, 0.0, 3.0]);
//! # Ok(())
//! # }
//! ```

#![forbid(unsafe_code)]

mod chain;
mod convolution;
mod error;
mod onnx;
mod pointwise;
mod tiles;
mod wire;
pub mod writing;

use chain::Chain;
use convolution::Convolution;
use tiles::Wanted;

pub use error::NetworkError;
pub use tiles::TILE_PX;

/// A network that was read.
#[derive(Clone, Debug)]
pub struct Network {
    chain: Chain,
    parameters: usize,
}

impl Network {
    /// Reads an ONNX file: a chain of `Conv` (odd windows, stride and dilation 1, any groups), `Relu`, `Clip`, `Sigmoid`,
    /// `Identity`, and `Add`, `Sub`, `Mul`, `Div` with a constant, from one channel to one.
    ///
    /// # Errors
    /// Bytes of something else, and whatever is not such a chain, by the name of its node.
    pub fn read(bytes: &[u8]) -> Result<Self, NetworkError> {
        let chain = chain::chain(bytes)?;
        let of = |convolution: &Convolution| convolution.products() as usize + convolution.outputs;
        let parameters = chain.stages.iter().map(|stage| of(&stage.convolution)).sum();
        Ok(Self { chain, parameters })
    }

    /// Numbers of its convolutions that were learned.
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// Multiplications for each pixel that is evaluated, those around it apart.
    pub fn products_a_pixel(&self) -> u64 {
        self.chain.stages.iter().map(|stage| stage.convolution.products()).sum()
    }

    /// How far a pixel looks to each side: rows and columns, px.
    pub fn reach_px(&self) -> [usize; 2] {
        let of =
            |k: usize| self.chain.stages.iter().map(|stage| stage.convolution.kernel[k] / 2).sum();
        [of(0), of(1)]
    }

    /// What a thread works in, bytes, at most.
    pub fn bytes_a_thread(&self) -> u64 {
        tiles::bytes_a_thread(&self.chain)
    }

    /// What the network makes of a picture, rows x `columns`, row by row; everywhere.
    ///
    /// # Errors
    /// Values that are no picture of so many columns, or not finite.
    pub fn run(&self, picture: &[f32], columns: usize) -> Result<Vec<f32>, NetworkError> {
        self.evaluate(picture, columns, Wanted::Everything)
    }

    /// The same where the picture is not zero, to the bit; zero elsewhere.
    ///
    /// # Errors
    /// As for [`Self::run`].
    pub fn run_touched(&self, picture: &[f32], columns: usize) -> Result<Vec<f32>, NetworkError> {
        self.evaluate(picture, columns, Wanted::Touched)
    }

    fn evaluate(
        &self,
        picture: &[f32],
        columns: usize,
        wanted: Wanted,
    ) -> Result<Vec<f32>, NetworkError> {
        let values = picture.len();
        if columns == 0 || !values.is_multiple_of(columns) {
            return Err(NetworkError::Picture { values, columns });
        }
        if picture.iter().any(|value| !value.is_finite()) {
            return Err(NetworkError::NotFinite);
        }
        Ok(tiles::evaluate(&self.chain, picture, columns, wanted))
    }
}
