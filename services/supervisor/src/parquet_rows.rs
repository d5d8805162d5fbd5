//! Rows of a table as Parquet: times are timestamps in UTC with microseconds, and missing values are null.

use std::io::Write;
use std::sync::Arc;

use anyhow::Context;
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type, TypePtr};
use vibrissa_store::export::{Cell, ExportColumn, ExportKind};

/// Number of rows in a row group. They are held in memory until the group is full: some 20 MB.
const GROUP_ROWS: usize = 65_536;

/// A Parquet file that is being written to `W`.
pub struct ParquetRows<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    columns: &'static [ExportColumn],
    /// The rows of the next row group, column by column.
    group: Vec<Vec<Cell>>,
}

impl<W: Write + Send> ParquetRows<W> {
    /// Begins the file.
    ///
    /// # Errors
    /// `W` cannot be written.
    pub fn begin(sink: W, name: &str, columns: &'static [ExportColumn]) -> anyhow::Result<Self> {
        let writer = SerializedFileWriter::new(sink, schema(name, columns)?, Arc::new(properties(columns)))?;
        Ok(Self { writer, columns, group: vec![Vec::new(); columns.len()] })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// `W` cannot be written.
    pub fn push(&mut self, cells: Vec<Cell>) -> anyhow::Result<()> {
        for (column, cell) in self.group.iter_mut().zip(cells) {
            column.push(cell);
        }
        if self.group.first().is_some_and(|column| column.len() == GROUP_ROWS) {
            self.write_group().context("cannot write the rows")?;
        }
        Ok(())
    }

    /// Writes the rest and the end of the file.
    ///
    /// # Errors
    /// `W` cannot be written.
    pub fn finish(mut self) -> anyhow::Result<W> {
        if self.group.first().is_some_and(|column| !column.is_empty()) {
            self.write_group().context("cannot write the rows")?;
        }
        self.writer.into_inner().context("cannot write the end of the file")
    }

    fn write_group(&mut self) -> anyhow::Result<()> {
        let mut writer = self.writer.next_row_group()?;
        for (column, cells) in self.columns.iter().zip(&mut self.group) {
            let mut chunk = writer.next_column()?.context("the schema has fewer columns than the table")?;
            write_chunk(&mut chunk, *column, std::mem::take(cells))?;
            chunk.close()?;
        }
        writer.close()?;
        Ok(())
    }
}

/// Differences of whole numbers are small, and of measurements only the first bytes repeat: without these encodings a contact
/// takes twice as many bytes.
fn properties(columns: &[ExportColumn]) -> WriterProperties {
    let plain = WriterProperties::builder().set_compression(Compression::SNAPPY);
    let encodings = columns.iter().filter_map(|column| {
        let encoding = match column.kind {
            ExportKind::Text => return None,
            ExportKind::Whole | ExportKind::Time => Encoding::DELTA_BINARY_PACKED,
            ExportKind::Real => Encoding::BYTE_STREAM_SPLIT,
        };
        Some((ColumnPath::from(column.name), encoding))
    });
    encodings
        .fold(plain, |all, (column, encoding)| {
            all.set_column_dictionary_enabled(column.clone(), false).set_column_encoding(column, encoding)
        })
        .build()
}

fn schema(name: &str, columns: &[ExportColumn]) -> anyhow::Result<TypePtr> {
    let fields = columns.iter().map(|column| {
        let (physical, logical) = match column.kind {
            ExportKind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            ExportKind::Whole => (Physical::INT64, None),
            ExportKind::Real => (Physical::DOUBLE, None),
            ExportKind::Time => (Physical::INT64, Some(LogicalType::timestamp(true, TimeUnit::MICROS))),
        };
        let repetition = if column.nullable { Repetition::OPTIONAL } else { Repetition::REQUIRED };
        let field = Type::primitive_type_builder(column.name, physical);
        Ok(Arc::new(field.with_logical_type(logical).with_repetition(repetition).build()?))
    });
    let fields: anyhow::Result<Vec<TypePtr>> = fields.collect();
    Ok(Arc::new(Type::group_type_builder(name).with_fields(fields?).build()?))
}

/// Writes the values of a column, and which rows have one.
fn write_chunk(chunk: &mut SerializedColumnWriter<'_>, column: ExportColumn, cells: Vec<Cell>) -> anyhow::Result<()> {
    let levels: Vec<i16> = cells.iter().map(|cell| i16::from(*cell != Cell::Null)).collect();
    anyhow::ensure!(column.nullable || !levels.contains(&0), "a row lacks its {}", column.name);
    let levels = column.nullable.then_some(levels.as_slice());
    let whole = |cell| match cell {
        Cell::Whole(number) | Cell::Time(number) => Some(number),
        Cell::Null | Cell::Text(_) | Cell::Real(_) => None,
    };
    let real = |cell| match cell {
        Cell::Real(number) => Some(number),
        Cell::Null | Cell::Text(_) | Cell::Whole(_) | Cell::Time(_) => None,
    };
    let text = |cell| match cell {
        Cell::Text(text) => Some(ByteArray::from(text.into_bytes())),
        Cell::Null | Cell::Whole(_) | Cell::Real(_) | Cell::Time(_) => None,
    };
    match column.kind {
        ExportKind::Text => {
            let values: Vec<ByteArray> = cells.into_iter().filter_map(text).collect();
            chunk.typed::<ByteArrayType>().write_batch(&values, levels, None)?
        }
        ExportKind::Whole | ExportKind::Time => {
            let values: Vec<i64> = cells.into_iter().filter_map(whole).collect();
            chunk.typed::<Int64Type>().write_batch(&values, levels, None)?
        }
        ExportKind::Real => {
            let values: Vec<f64> = cells.into_iter().filter_map(real).collect();
            chunk.typed::<DoubleType>().write_batch(&values, levels, None)?
        }
    };
    Ok(())
}
