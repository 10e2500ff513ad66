//! The rings that a press can touch, and the displacements that tractions on them cause.

use std::ops::Range;
use std::sync::Arc;

use rustfft::num_complex::Complex;

use crate::compliance::{ALONG, AROUND, Compliance, NORMAL};
use crate::rings::Buffers;
use crate::stack::ElasticStack;

/// A range of consecutive rings. Nodal values are stored ring after ring.
pub(crate) struct Patch<'a> {
    pub stack: &'a ElasticStack,
    pub rings: Range<usize>,
    /// Compliances by harmonic. They cover at least these rings, and tangential tractions if those are needed.
    pub compliances: Arc<Vec<Compliance>>,
}

/// Complex amplitudes by harmonic and ring of a patch.
#[derive(Clone, Default)]
pub(crate) struct Spectrum {
    rings: usize,
    real: Vec<f64>,
    imaginary: Vec<f64>,
}

impl Spectrum {
    fn reset(&mut self, harmonics: usize, rings: usize) {
        self.rings = rings;
        for part in [&mut self.real, &mut self.imaginary] {
            part.clear();
            part.resize((harmonics + 1) * rings, 0.0);
        }
    }

    pub fn at(&self, harmonic: usize, ring: usize) -> Complex<f64> {
        let i = harmonic * self.rings + ring;
        Complex::new(self.real[i], self.imaginary[i])
    }

    fn set(&mut self, harmonic: usize, ring: usize, value: Complex<f64>) {
        let i = harmonic * self.rings + ring;
        (self.real[i], self.imaginary[i]) = (value.re, value.im);
    }
}

/// Buffers of [`Patch::apply`], reused from one product to the next.
#[derive(Default)]
pub(crate) struct Workspace {
    pub loads: [Spectrum; 3],
    displacements: [Spectrum; 3],
    buffers: Buffers,
}

impl Patch<'_> {
    pub fn nodes(&self) -> usize {
        self.node_range(self.rings.len()).start
    }

    /// Returns the range of nodal values of a ring. For the ring past the last it is empty and begins at the number of
    /// nodes.
    pub fn node_range(&self, ring: usize) -> Range<usize> {
        let all = &self.stack.rings;
        let first = |ring: usize| all.rings.get(ring).map_or(all.nodes, |ring| ring.first);
        let begin = first(self.rings.start);
        let here = self.rings.start + ring;
        first(here) - begin..first((here + 1).min(all.rings.len())) - begin
    }

    /// Highest harmonic of any ring of the patch.
    pub fn harmonics(&self) -> usize {
        self.stack.rings.rings[self.rings.end - 1].harmonics
    }

    /// Area that each node stands for, mm2.
    pub fn areas(&self) -> Vec<f64> {
        let rings = self.rings.clone();
        let area = |ring: usize| {
            let count = self.stack.rings.rings[ring].count;
            std::iter::repeat_n(self.stack.rings.area_mm2(ring), count)
        };
        rings.flat_map(area).collect()
    }

    /// Transforms nodal values of the components to amplitudes in `work.loads`.
    pub fn analyse(&self, values: [Option<&[f64]>; 3], work: &mut Workspace) {
        let (rings, harmonics) = (self.rings.len(), self.harmonics());
        for component in [NORMAL, ALONG, AROUND] {
            let Some(values) = values[component] else { continue };
            let spectrum = &mut work.loads[component];
            spectrum.reset(harmonics, rings);
            for ring in 0..rings {
                let here = &values[self.node_range(ring)];
                // The circumferential component is a sine series where the others are cosine series: a quarter turn
                // ahead.
                let turn = if component == AROUND { Complex::i() } else { Complex::new(1.0, 0.0) };
                let all = &self.stack.rings;
                all.analyse(self.rings.start + ring, here, &mut work.buffers, |m, amplitude| {
                    spectrum.set(m, ring, turn * amplitude);
                });
            }
        }
        if self.rings.start == 0 && harmonics > 0 {
            // On the axis the tangential pair is a vector (x, y), that is, an amplitude of harmonic 1.
            let [x, y] = [ALONG, AROUND].map(|c| values[c].map_or(0.0, |values| values[0]));
            for (component, sign) in [(ALONG, 1.0), (AROUND, -1.0)] {
                if values[component].is_some() {
                    work.loads[component].set(0, 0, Complex::default());
                    work.loads[component].set(1, 0, Complex::new(x, -y) * sign);
                }
            }
        }
    }

    /// Computes the displacements, mm, that tractions, MPa, cause, for the components that are given.
    ///
    /// The two tangential components must be given or left out together.
    pub fn apply(
        &self,
        loads: [Option<&[f64]>; 3],
        moved: [Option<&mut [f64]>; 3],
        work: &mut Workspace,
    ) {
        self.analyse(loads, work);
        let harmonics = self.harmonics();
        let wanted: [bool; 3] = std::array::from_fn(|c| moved[c].is_some());
        for (spectrum, wanted) in work.displacements.iter_mut().zip(wanted) {
            if wanted {
                spectrum.reset(harmonics, self.rings.len());
            }
        }
        for harmonic in 0..=harmonics {
            for load in (0..3).filter(|&c| loads[c].is_some()) {
                for component in (0..3).filter(|&c| wanted[c]) {
                    self.multiply(harmonic, load, component, work);
                }
            }
        }
        self.synthesise(moved, work);
    }

    /// Multiplies one load component's amplitudes by one block of a harmonic's compliance and adds the result to a
    /// displacement component.
    fn multiply(&self, harmonic: usize, load: usize, component: usize, work: &mut Workspace) {
        let block = &self.compliances[harmonic];
        let rows = block.components * block.rings;
        // Rings further in than the block's first do not carry this harmonic.
        // Offsets of the patch's rings within the block, whose columns hold all components one after the other.
        let start = self.rings.start.max(block.first);
        if start >= self.rings.end {
            return;
        }
        let offset = start - self.rings.start;
        let count = self.rings.end - start;
        let (loads, moved) = (&work.loads[load], &mut work.displacements[component]);
        let row = harmonic * self.rings.len() + offset;
        let real = &mut moved.real[row..row + count];
        let imaginary = &mut moved.imaginary[row..row + count];
        for ring in 0..count {
            let amplitude = loads.at(harmonic, offset + ring);
            let column = (load * block.rings + start - block.first + ring) * rows;
            let begin = column + component * block.rings + start - block.first;
            let column = &block.contact[begin..begin + count];
            for ((real, imaginary), entry) in real.iter_mut().zip(imaginary.iter_mut()).zip(column)
            {
                *real += entry * amplitude.re;
                *imaginary += entry * amplitude.im;
            }
        }
    }

    /// Transforms the amplitudes in `work.moved` back to nodal values: the inverse of `analyse`.
    fn synthesise(&self, moved: [Option<&mut [f64]>; 3], work: &mut Workspace) {
        let harmonics = self.harmonics();
        // Inverse of the special case in `analyse`: harmonic 1 on the axis is a vector across it.
        let on_axis = if self.rings.start == 0 && harmonics > 0 && moved[ALONG].is_some() {
            Some((work.displacements[ALONG].at(1, 0) - work.displacements[AROUND].at(1, 0)) * 0.5)
        } else {
            None
        };
        for (component, values) in moved.into_iter().enumerate() {
            let Some(values) = values else { continue };
            let spectrum = &work.displacements[component];
            for ring in 0..self.rings.len() {
                let here = &mut values[self.node_range(ring)];
                let turn = if component == AROUND { -Complex::i() } else { Complex::new(1.0, 0.0) };
                let all = &self.stack.rings;
                all.synthesise(self.rings.start + ring, here, &mut work.buffers, |m| {
                    turn * spectrum.at(m, ring)
                });
            }
            match (on_axis, component) {
                (Some(across), ALONG) => values[0] = across.re,
                (Some(across), AROUND) => values[0] = -across.im,
                _ => {}
            }
        }
    }
}
