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
///
/// ```
/// use fabkit_network::Network;
/// use fabkit_network::writer::{ChainLayer, write_chain};
///
/// // A mean of 3 x 3 pixels: outside of the image there are zeros, so that a corner keeps four ninths.
/// let mean = ChainLayer::convolution([1, 1, 3, 3], 1, &[1.0 / 9.0; 9], &[0.0]);
/// let network = Network::read(&write_chain(&[mean]))?;
/// let means = network.run(&[9.0; 9], 3)?;
/// assert!((means[4] - 9.0).abs() < 1e-5 && (means[0] - 4.0).abs() < 1e-5);
/// # Ok::<(), fabkit_network::NetworkError>(())
/// ```
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
    ///
    /// ```
    /// use fabkit_network::writer::{ChainLayer, write_chain};
    /// use fabkit_network::{Network, NetworkError};
    ///
    /// assert_eq!(Network::read(b"no model").err(), Some(NetworkError::NotOnnx));
    /// // What is not read is named.
    /// let scale = ChainLayer::convolution([1, 1, 1, 1], 1, &[2.0], &[0.0]);
    /// let pooled = write_chain(&[scale, ChainLayer::operator("MaxPool")]);
    /// assert!(Network::read(&pooled).unwrap_err().to_string().contains("MaxPool is not known"));
    /// ```
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
    ///
    /// ```
    /// use fabkit_network::Network;
    /// use fabkit_network::writer::{ChainLayer, write_chain};
    ///
    /// // One channel to two by windows of 5 x 5, and back to one by 1 x 1.
    /// let wide = ChainLayer::convolution([2, 1, 5, 5], 1, &[0.1; 50], &[0.0; 2]);
    /// let back = ChainLayer::convolution([1, 2, 1, 1], 1, &[1.0; 2], &[0.0]);
    /// let network = Network::read(&write_chain(&[wide, back]))?;
    /// // 50 weights and 2 biases, then 2 weights and 1 bias; biases are added, not multiplied.
    /// assert_eq!((network.parameters(), network.multiplications_per_pixel()), (55, 52));
    /// # Ok::<(), fabkit_network::NetworkError>(())
    /// ```
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// Returns the number of multiplications per evaluated pixel, without those for its surroundings.
    pub fn multiplications_per_pixel(&self) -> u64 {
        self.chain.stages.iter().map(|stage| stage.convolution.multiplications_per_pixel()).sum()
    }

    /// Returns how many pixels to each side influence an output pixel: rows and columns, px.
    ///
    /// ```
    /// use fabkit_network::Network;
    /// use fabkit_network::writer::{ChainLayer, write_chain};
    ///
    /// // Windows of 3 rows x 5 columns, twice: each adds half of itself.
    /// let blur = ChainLayer::convolution([1, 1, 3, 5], 1, &[0.1; 15], &[0.0]);
    /// let network = Network::read(&write_chain(&[blur.clone(), blur]))?;
    /// assert_eq!(network.reach_px(), [2, 4]);
    /// # Ok::<(), fabkit_network::NetworkError>(())
    /// ```
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
    ///
    /// ```
    /// use fabkit_network::writer::{ChainLayer, write_chain};
    /// use fabkit_network::{Network, NetworkError};
    ///
    /// let double = ChainLayer::convolution([1, 1, 1, 1], 1, &[2.0], &[0.5]);
    /// let network = Network::read(&write_chain(&[double]))?;
    /// assert_eq!(network.run(&[1.0, 2.0, 3.0, 4.0], 2)?, [2.5, 4.5, 6.5, 8.5]);
    /// // Four values are no rows of three.
    /// let error = network.run(&[1.0, 2.0, 3.0, 4.0], 3).unwrap_err();
    /// assert_eq!(error, NetworkError::ImageShape { values: 4, columns: 3 });
    /// assert_eq!(network.run(&[f32::NAN], 1).unwrap_err(), NetworkError::NotFinite);
    /// # Ok::<(), fabkit_network::NetworkError>(())
    /// ```
    pub fn run(&self, image: &[f32], columns: usize) -> Result<Vec<f32>, NetworkError> {
        self.evaluate(image, columns, OutputRegion::Everything)
    }

    /// Evaluates the network where the image is not zero, with the same bits as [`Self::run`]; the output is zero
    /// elsewhere.
    ///
    /// # Errors
    /// As for [`Self::run`].
    ///
    /// ```
    /// use fabkit_network::Network;
    /// use fabkit_network::writer::{ChainLayer, write_chain};
    ///
    /// // A bias makes even untouched pixels deep; they are set to zero.
    /// let biased = ChainLayer::convolution([1, 1, 1, 1], 1, &[2.0], &[0.5]);
    /// let network = Network::read(&write_chain(&[biased]))?;
    /// let difference = [0.0, 1.0, 0.0, -1.0];
    /// assert_eq!(network.run(&difference, 2)?, [0.5, 2.5, 0.5, -1.5]);
    /// assert_eq!(network.run_nonzero(&difference, 2)?, [0.0, 2.5, 0.0, -1.5]);
    /// # Ok::<(), fabkit_network::NetworkError>(())
    /// ```
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
