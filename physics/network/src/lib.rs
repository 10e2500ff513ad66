//! Evaluation of depth networks given as ONNX, restricted to the pixels in contact if wanted.
//!
//! A network of a tactile sensor is small: some convolutions with pointwise operations between them. Only this part of
//! ONNX is read ([`Network::read`]); everything else is refused, with the name of its node. The crate knows no sensors
//! or cameras, nor the meaning of intensities.
//!
//! # Conventions
//!
//! - Values are `f32`, row by row. The input image has one channel; the output has one channel and the same size.
//! - Maps keep their size: strides and dilations are 1, and paddings are half of each window, with zeros.
//! - The same network and image give the same bits, on any number of threads and with registers of any width: each
//!   number is one sum in a fixed order, of fused multiply-adds that round once.
//!
//! Without contact, the difference to the image at rest is zero. Depth networks are not trained there, and their
//! authors set the output to zero (R-Tac0). [`Network::run_nonzero`] skips such pixels tile by tile, and returns the
//! same bits as [`Network::run`] elsewhere.
//!
//! ```
//! use fabkit_network::Network;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // y = relu(2 x), as an ONNX file: one node of kind Conv, one Relu.
//! let file = fabkit_network::writer::write_chain(&[
//!     fabkit_network::writer::ChainLayer::convolution([1, 1, 1, 1], 1, &[2.0], &[0.0]),
//!     fabkit_network::writer::ChainLayer::operator("Relu"),
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
pub mod writer;

use chain::Chain;
use convolution::Convolution;
use tiles::OutputRegion;

pub use error::NetworkError;
pub use tiles::TILE_PX;

/// Network that can be evaluated.
#[derive(Clone, Debug)]
pub struct Network {
    chain: Chain,
    parameters: usize,
}

impl Network {
    /// Reads an ONNX file: a chain of `Conv` (odd windows, stride and dilation 1, any groups), `Relu`, `Clip`,
    /// `Sigmoid`, `Identity`, and `Add`, `Sub`, `Mul`, `Div` with a constant, from one channel to one.
    ///
    /// # Errors
    /// If the bytes are not an ONNX model, or the graph is not such a chain; the message names the node.
    pub fn read(bytes: &[u8]) -> Result<Self, NetworkError> {
        let chain = chain::read_chain(bytes)?;
        // Each weight is multiplied once per pixel; each output has a bias.
        let of = |convolution: &Convolution| {
            convolution.multiplications_per_pixel() as usize + convolution.outputs
        };
        let parameters = chain.stages.iter().map(|stage| of(&stage.convolution)).sum();
        Ok(Self { chain, parameters })
    }

    /// Returns the number of learned parameters of the convolutions.
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// Returns the number of multiplications per evaluated pixel, without those for its surroundings.
    pub fn multiplications_per_pixel(&self) -> u64 {
        self.chain.stages.iter().map(|stage| stage.convolution.multiplications_per_pixel()).sum()
    }

    /// Returns how many pixels to each side influence an output pixel: rows and columns, px.
    pub fn reach_px(&self) -> [usize; 2] {
        let of =
            |k: usize| self.chain.stages.iter().map(|stage| stage.convolution.kernel[k] / 2).sum();
        [of(0), of(1)]
    }

    /// Returns the maximum working memory of a thread, bytes.
    pub fn bytes_a_thread(&self) -> u64 {
        tiles::bytes_per_thread(&self.chain)
    }

    /// Evaluates the network at every pixel of an image with `columns` columns, row by row.
    ///
    /// # Errors
    /// If the values do not form complete rows, or are not finite.
    pub fn run(&self, image: &[f32], columns: usize) -> Result<Vec<f32>, NetworkError> {
        self.evaluate(image, columns, OutputRegion::Everything)
    }

    /// Evaluates the network where the image is not zero, with the same bits as [`Self::run`]; the output is zero
    /// elsewhere.
    ///
    /// # Errors
    /// As for [`Self::run`].
    pub fn run_nonzero(&self, image: &[f32], columns: usize) -> Result<Vec<f32>, NetworkError> {
        self.evaluate(image, columns, OutputRegion::Nonzero)
    }

    /// Checks the image and evaluates the network.
    fn evaluate(
        &self,
        image: &[f32],
        columns: usize,
        wanted: OutputRegion,
    ) -> Result<Vec<f32>, NetworkError> {
        let values = image.len();
        if columns == 0 || !values.is_multiple_of(columns) {
            return Err(NetworkError::ImageShape { values, columns });
        }
        if image.iter().any(|value| !value.is_finite()) {
            return Err(NetworkError::NotFinite);
        }
        Ok(tiles::evaluate(&self.chain, image, columns, wanted))
    }
}
