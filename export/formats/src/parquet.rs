//! Tables as Parquet files.

use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::ExportError;

/// Number of rows per row group.
const GROUP: usize = 16_384;

/// One column of a table, a value for each row.
///
/// ```
/// use fabkit_export::{ParquetColumn, parquet};
///
/// let variant = ParquetColumn::Integers(vec![0, 1, 2]);
/// let coverage = ParquetColumn::Numbers(vec![Some(0.5), None, Some(0.75)]);
/// assert_eq!((variant.len(), coverage.len()), (3, 3));
/// let uneven = [("variant".to_owned(), variant), ("ok".to_owned(), ParquetColumn::Flags(vec![None]))];
/// assert!(parquet("sweep", &uneven).is_err());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum ParquetColumn {
    /// Integers.
    Integers(Vec<i64>),
    /// Numbers; empty cells are null.
    Numbers(Vec<Option<f64>>),
    /// Texts; empty cells are null.
    Texts(Vec<Option<String>>),
    /// Booleans; empty cells are null.
    Flags(Vec<Option<bool>>),
}

impl ParquetColumn {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Integers(values) => values.len(),
            Self::Numbers(values) => values.len(),
            Self::Texts(values) => values.len(),
            Self::Flags(values) => values.len(),
        }
    }

    /// Returns whether the column has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn physical(&self) -> Physical {
        match self {
            Self::Integers(_) => Physical::INT64,
            Self::Numbers(_) => Physical::DOUBLE,
            Self::Texts(_) => Physical::BYTE_ARRAY,
            Self::Flags(_) => Physical::BOOLEAN,
        }
    }
}

/// Writes named columns of equal length as a Parquet file, uncompressed.
///
/// ```
/// use fabkit_export::{ParquetColumn, parquet};
/// let columns = [
///     ("variant".to_owned(), ParquetColumn::Integers(vec![0, 1])),
///     ("coverage".to_owned(), ParquetColumn::Numbers(vec![Some(0.5), None])),
/// ];
/// let bytes = parquet("sweep", &columns)?;
/// assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
///
/// # Errors
/// Columns of different lengths, or no columns.
pub fn parquet(name: &str, columns: &[(String, ParquetColumn)]) -> Result<Vec<u8>, ExportError> {
    let rows = columns.first().map_or(0, |(_, column)| column.len());
    if columns.is_empty() || columns.iter().any(|(_, column)| column.len() != rows) {
        return Err(ExportError::Table("its columns are not of one length".into()));
    }
    write(name, columns, rows).map_err(|error| ExportError::Table(error.to_string()))
}

/// Writes columns of equal length in row groups.
fn write(
    name: &str,
    columns: &[(String, ParquetColumn)],
    rows: usize,
) -> Result<Vec<u8>, ParquetError> {
    let fields = columns.iter().map(|(name, column)| {
        let repetition = match column {
            ParquetColumn::Integers(_) => Repetition::REQUIRED,
            _ => Repetition::OPTIONAL,
        };
        let logical = matches!(column, ParquetColumn::Texts(_)).then_some(LogicalType::String);
        let field = Type::primitive_type_builder(name, column.physical());
        field.with_repetition(repetition).with_logical_type(logical).build().map(Arc::new)
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder(name).with_fields(fields).build()?);
    // Set explicitly, so that the bytes do not change with the library's version.
    let maker = format!("fabkit {}", crate::VERSION);
    let properties = Arc::new(WriterProperties::builder().set_created_by(maker).build());
    let mut file = SerializedFileWriter::new(Vec::new(), schema, properties)?;
    for from in (0..rows).step_by(GROUP) {
        let to = rows.min(from + GROUP);
        let mut group = file.next_row_group()?;
        for (_, column) in columns {
            let Some(mut writer) = group.next_column()? else { break };
            match column {
                ParquetColumn::Integers(values) => {
                    writer.typed::<Int64Type>().write_batch(&values[from..to], None, None)?;
                }
                ParquetColumn::Numbers(values) => {
                    let (values, levels) = dense(&values[from..to], |value| *value);
                    writer.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
                }
                ParquetColumn::Texts(values) => {
                    let bytes = |text: &String| ByteArray::from(text.as_str());
                    let (values, levels) = dense(&values[from..to], bytes);
                    writer.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)?;
                }
                ParquetColumn::Flags(values) => {
                    let (values, levels) = dense(&values[from..to], |value| *value);
                    writer.typed::<BoolType>().write_batch(&values, Some(&levels), None)?;
                }
            }
            writer.close()?;
        }
        group.close()?;
    }
    file.into_inner()
}

/// Splits cells into the values that are present and a definition level (1 or 0) for each cell.
fn dense<T, U>(cells: &[Option<T>], value: impl Fn(&T) -> U) -> (Vec<U>, Vec<i16>) {
    let levels = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    (cells.iter().flatten().map(value).collect(), levels)
}
