//! Writes many contacts at once, in the binary format of `COPY`.

use sqlx::postgres::PgConnection;

use super::rows;
use crate::batch::ContactRow;

/// Number of contacts from which on `COPY` is faster than `INSERT`.
const COPIED: usize = 2000;

/// Appends contacts. `COPY` in its binary format costs the server half of the work of an `INSERT`. But sqlx sends the
/// rows and their end in two writes without TCP_NODELAY: the end waits for the acknowledgement of the rows, which the
/// operating system delays by 40 ms. So few contacts are inserted with a single statement.
pub(in super::super) async fn append_contacts(tx: &mut PgConnection, contacts: &[ContactRow]) -> sqlx::Result<()> {
    if are_copied(contacts) {
        copy_contacts(tx, contacts).await
    } else {
        rows::bind_contacts(rows::alone(rows::CONTACTS), contacts).execute(tx).await.map(drop)
    }
}

/// Whether there are enough contacts for `COPY`.
pub(super) fn are_copied(contacts: &[ContactRow]) -> bool {
    contacts.len() >= COPIED
}

async fn copy_contacts(tx: &mut PgConnection, contacts: &[ContactRow]) -> sqlx::Result<()> {
    let mut copy = tx
        .copy_in_raw(
            "COPY contacts (whisker_id, boot, seq, position, t_us, received_us, ratio, deflection_mm, strain, \
             pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm) FROM STDIN (FORMAT BINARY)",
        )
        .await?;
    copy.send(copy_of(contacts)).await?;
    copy.finish().await.map(drop)
}

/// Number of columns of a contact.
const CONTACT_COLUMNS: u16 = 15;
/// Most bytes of a contact in the binary format: each value has its length in front of it.
const CONTACT_BYTES: usize = 2 + CONTACT_COLUMNS as usize * (4 + 8) + 8;

/// Contacts in the binary format of `COPY`.
fn copy_of(contacts: &[ContactRow]) -> Vec<u8> {
    // Signature, flags, and the length of the header extension, which is empty.
    let mut copy = Vec::with_capacity(32 + contacts.len() * CONTACT_BYTES);
    copy.extend(b"PGCOPY\n\xff\r\n\0");
    copy.extend([0; 8]);
    for row in contacts {
        copy.extend(CONTACT_COLUMNS.to_be_bytes());
        for whole in [row.whisker_id, row.boot, row.seq, row.position, row.t_us, row.received_us] {
            push(&mut copy, &whole.to_be_bytes());
        }
        for number in [row.ratio, row.deflection_mm, row.strain, row.pressure_mpa, row.temperature_c] {
            push(&mut copy, &number.to_be_bytes());
        }
        push(&mut copy, row.used.as_bytes());
        match row.residual {
            Some(residual) => push(&mut copy, &residual.to_be_bytes()),
            None => copy.extend((-1_i32).to_be_bytes()),
        }
        push(&mut copy, &row.length_mm.to_be_bytes());
        push(&mut copy, &row.length_sd_mm.to_be_bytes());
    }
    copy.extend((-1_i16).to_be_bytes());
    copy
}

fn push(copy: &mut Vec<u8>, value: &[u8]) {
    copy.extend((value.len() as u32).to_be_bytes());
    copy.extend(value);
}
