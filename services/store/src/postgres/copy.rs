//! Writes many contacts at once, in the binary format of `COPY`. It costs the server half of the work of an `INSERT`.

use std::borrow::Borrow;

use sqlx::postgres::PgConnection;

use crate::batch::ContactRow;
use crate::row::{Row, Value};

/// Number of contacts from which on `COPY` is faster than `INSERT`: sqlx sends the rows and their end in two writes
/// without TCP_NODELAY. The end waits for the acknowledgement of the rows, which the operating system delays by 40 ms.
const COPIED: usize = 2000;

/// Whether so many contacts are written by `COPY`.
pub(in super::super) fn are_copied(contacts: usize) -> bool {
    contacts >= COPIED
}

/// Appends contacts.
pub(in super::super) async fn copy_contacts<R: Borrow<ContactRow>>(
    tx: &mut PgConnection,
    contacts: &[R],
) -> sqlx::Result<()> {
    let names: Vec<&str> = ContactRow::columns().iter().map(|column| column.name).collect();
    let sql = format!("COPY contacts ({}) FROM STDIN (FORMAT BINARY)", names.join(", "));
    let mut copy = tx.copy_in_raw(&sql).await?;
    copy.send(copy_of::<ContactRow>(contacts, names.len())).await?;
    copy.finish().await.map(drop)
}

/// Rows in the binary format of `COPY`.
fn copy_of<R: Row>(rows: &[impl Borrow<R>], columns: usize) -> Vec<u8> {
    // A value has at most 8 bytes, with its length in front; few are longer.
    let row_bytes = 2 + columns * (4 + 8) + 8;
    // Signature, flags, and the length of the header extension, which is empty.
    let mut copy = Vec::with_capacity(32 + rows.len() * row_bytes);
    copy.extend(b"PGCOPY\n\xff\r\n\0");
    copy.extend([0; 8]);
    for row in rows {
        copy.extend((columns as u16).to_be_bytes());
        row.borrow().put(&mut |value| push(&mut copy, value));
    }
    copy.extend((-1_i16).to_be_bytes());
    copy
}

fn push(copy: &mut Vec<u8>, value: Value<'_>) {
    let mut put = |bytes: Option<&[u8]>| match bytes {
        Some(bytes) => {
            copy.extend((bytes.len() as u32).to_be_bytes());
            copy.extend(bytes);
        }
        None => copy.extend((-1_i32).to_be_bytes()),
    };
    match value {
        Value::Bigint(value) => put(value.map(i64::to_be_bytes).as_ref().map(<[u8; 8]>::as_slice)),
        Value::Integer(value) => put(value.map(i32::to_be_bytes).as_ref().map(<[u8; 4]>::as_slice)),
        Value::Double(value) => put(value.map(f64::to_be_bytes).as_ref().map(<[u8; 8]>::as_slice)),
        Value::Real(value) => put(value.map(f32::to_be_bytes).as_ref().map(<[u8; 4]>::as_slice)),
        Value::Boolean(value) => put(value.map(|value| [u8::from(value)]).as_ref().map(<[u8; 1]>::as_slice)),
        Value::Text(value) => put(value.map(str::as_bytes)),
        Value::Bytes(value) => put(value),
    }
}
