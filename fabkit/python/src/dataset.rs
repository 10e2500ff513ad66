//! Writing of data sets, and reading of single samples.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use fabkit::{ContactOptions, DatasetOptions};
use fabkit_application::dataset::{
    self, DatasetError, DatasetJob, DatasetRequest, DatasetWriter, SampleArray, WrittenDataset,
};
use fabkit_application::export::ZarrType;
use fabkit_application::progress::ProgressStep;
use fabkit_application::scene;
use fabkit_application::source::convert_press_error;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays::into_array;
use crate::errors::{Failure, OrRaise};
use crate::keywords::Keywords;
use crate::running::{InterruptPolicy, run_on_thread, run_short};
use crate::scene::Scene;

/// File: path relative to the folder, and content.
type NamedBytes<'py> = (String, Bound<'py, PyBytes>);

/// Request for a data set.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct DatasetOrder {
    scene: Arc<scene::SensorView>,
    sensor: String,
    options: DatasetOptions,
    contact: ContactOptions,
}

#[pymethods]
impl DatasetOrder {
    /// Makes a request. Options are those of [`DatasetOptions`] and [`ContactOptions`], by name.
    #[new]
    fn new(scene: &Scene, options: &Bound<'_, PyDict>) -> PyResult<Self> {
        let (scene, sensor) = (Arc::clone(&scene.scene), scene.sensor.clone());
        let contact = ContactOptions::from_named(&Keywords(options))?;
        let options = DatasetOptions::from_named(&Keywords(options))?;
        Ok(Self { scene, sensor, options, contact })
    }

    /// Writes the data set, or what is missing of it. Returns the halves whose press the camera does not see.
    #[pyo3(signature = (folder, progress))]
    fn write(
        slf: Bound<'_, Self>,
        folder: PathBuf,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<String>> {
        let order = slf.clone().unbind();
        let written: WrittenDataset =
            run_on_thread(slf.py(), InterruptPolicy::Wait, progress, move |link| {
                let order = order.get();
                order.prepare(order.options.resume, |job| {
                    let show = |step: ProgressStep| link.show(step.done, step.total);
                    dataset::write(&folder, job, &show, &|| link.is_cancelled())
                })
            })?;
        Ok(written.halves_without_contact)
    }

    /// Begins the data set, or resumes it.
    fn begin(slf: Bound<'_, Self>, folder: PathBuf) -> PyResult<BegunDataset> {
        let order = slf.clone().unbind();
        let begun = run_on_thread(slf.py(), InterruptPolicy::Wait, None, move |_| {
            let order = order.get();
            order.prepare(order.options.resume, |job| dataset::begin(&folder, job))
        })?;
        Ok(BegunDataset { order: slf.unbind(), begun: Mutex::new(Some(begun)) })
    }

    /// Computes a shard: the plan's hash, and the files as paths relative to the folder with their bytes.
    fn shard<'py>(slf: Bound<'py, Self>, number: u64) -> PyResult<(String, Vec<NamedBytes<'py>>)> {
        let (py, order) = (slf.py(), slf.clone().unbind());
        let (plan, files) = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            order.get().prepare(true, |job| dataset::compute_shard(job, number))
        })?;
        let files = files.into_iter().map(|(name, bytes)| (name, PyBytes::new(py, &bytes)));
        Ok((plan, files.collect()))
    }
}

impl DatasetOrder {
    fn prepare<R>(
        &self,
        resume: bool,
        work: impl FnOnce(&DatasetJob) -> Result<R, DatasetError>,
    ) -> Result<R, Failure> {
        let order = DatasetRequest { resume, ..self.options.request(&self.contact)? };
        let explain = |error| convert_press_error(&self.sensor, error);
        dataset::prepare_job(&self.scene, &explain, &order, |job, _| Ok(work(job)?))
    }
}

/// Data set that is being written. Its folder is locked until it is closed.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct BegunDataset {
    order: Py<DatasetOrder>,
    /// `None` once it is closed.
    begun: Mutex<Option<DatasetWriter>>,
}

impl BegunDataset {
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Option<DatasetWriter>) -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        let result = run_short(py, || match self.begun.lock() {
            Ok(mut begun) => work(&mut begun),
            Err(error) => Err(Failure::bug(error)),
        });
        result?.or_raise(py)
    }
}

fn closed() -> Failure {
    Failure::bug("the data set is closed")
}

#[pymethods]
impl BegunDataset {
    /// The plan's hash, and the numbers of the missing shards.
    fn missing(&self, py: Python<'_>) -> PyResult<(String, Vec<u64>)> {
        self.with(py, |begun| {
            let begun = begun.as_ref().ok_or_else(closed)?;
            Ok((begun.plan_hash(), begun.missing_shards()))
        })
    }

    /// Stores the files of a shard that another process computed.
    fn keep(&self, py: Python<'_>, files: Vec<(String, Vec<u8>)>) -> PyResult<()> {
        self.with(py, |begun| Ok(begun.as_ref().ok_or_else(closed)?.keep_shard(&files)?))
    }

    /// Computes and writes the missing shards.
    #[pyo3(signature = (progress))]
    fn write(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
        // Taken out of the lock: writing takes long, and closes the data set in the end.
        let begun = self.with(py, |begun| begun.take().ok_or_else(closed))?;
        let order = self.order.clone_ref(py);
        let written: WrittenDataset =
            run_on_thread(py, InterruptPolicy::Wait, progress, move |link| {
                // The folder has been begun, so that writing resumes it in any case.
                order.get().prepare(true, |job| {
                    let show = |step: ProgressStep| link.show(step.done, step.total);
                    begun.write(job, &show, &|| link.is_cancelled())
                })
            })?;
        Ok(written.halves_without_contact)
    }

    /// Releases the folder's lock.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, |begun| {
            *begun = None;
            Ok(())
        })
    }
}

/// Reader of a finished data set. Everything read is verified against its checksums.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct DatasetReader {
    reader: dataset::DatasetReader,
}

#[pymethods]
impl DatasetReader {
    #[new]
    fn new(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let reader = run_short(py, || dataset::DatasetReader::open(&folder))?.or_raise(py)?;
        Ok(Self { reader })
    }

    /// The content of `dataset.json`.
    fn document(&self) -> String {
        self.reader.document().to_string()
    }

    fn content<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = run_short(py, || self.reader.bytes(name))?.or_raise(py)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Opens an array such as `halves/label`; `None` if it does not exist.
    fn array(&self, py: Python<'_>, name: &str) -> PyResult<Option<Samples>> {
        let array = run_short(py, || self.reader.array(name))?.or_raise(py)?;
        Ok(array.map(|array| Samples { array }))
    }
}

/// Array whose first axis counts samples.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Samples {
    array: SampleArray,
}

#[pymethods]
impl Samples {
    fn shape(&self) -> Vec<usize> {
        self.array.shape().to_vec()
    }

    fn dtype(&self) -> &'static str {
        match self.array.element() {
            ZarrType::F32 => "float32",
            ZarrType::U16 => "uint16",
            ZarrType::U8 => "uint8",
        }
    }

    fn sample<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyAny>> {
        let bytes = run_short(py, || self.array.sample(index))?.or_raise(py)?;
        let shape = &self.array.shape()[1..];
        Ok(match self.array.element() {
            ZarrType::U8 => into_array(py, bytes, shape)?.into_any(),
            ZarrType::U16 => {
                let values = bytes.as_chunks().0.iter().map(|value| u16::from_le_bytes(*value));
                into_array(py, values.collect(), shape)?.into_any()
            }
            ZarrType::F32 => {
                let values = bytes.as_chunks().0.iter().map(|value| f32::from_le_bytes(*value));
                into_array(py, values.collect(), shape)?.into_any()
            }
        })
    }
}
