//! Admission of drivers.
//!
//! A child process and a serial device are known. A Unix socket is the agent's own, with mode 0600. At a TCP port anybody can
//! arrive or answer: the first line must be the token, or the peer's socket must belong to the agent's user on this machine.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt};
use tokio::time::timeout;

use vibrissa_program::files::own_uid;

/// Time in which the line with the token must come.
const TOKEN_TIMEOUT: Duration = Duration::from_secs(5);
/// Longest such line.
const TOKEN_LINE_MAX_BYTES: usize = 1024;
/// State of a connected socket in the kernel's table.
const ESTABLISHED: &str = "01";
/// State of a listening socket in the kernel's table.
const LISTENS: &str = "0A";

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct TokenLine<'a> {
    #[serde(rename = "type", borrow)]
    kind: std::borrow::Cow<'a, str>,
    #[serde(borrow)]
    token: std::borrow::Cow<'a, str>,
}

fn refused(problem: &str) -> io::Error {
    io::Error::new(io::ErrorKind::PermissionDenied, problem.to_owned())
}

/// Reads the first line, which must be `{"type":"token","token":"..."}`. Nothing is sent before.
pub(super) async fn expect_token(reader: &mut (impl AsyncRead + Unpin), token: &str) -> io::Result<()> {
    let line = timeout(TOKEN_TIMEOUT, first_line(reader)).await;
    let line = line.map_err(|_| refused("the driver has sent no token (driver.token_file) within 5 s"))??;
    let is_right = serde_json::from_slice::<TokenLine<'_>>(&line)
        .is_ok_and(|hello| hello.kind == "token" && is_same(hello.token.as_bytes(), token.as_bytes()));
    if is_right { Ok(()) } else { Err(refused("the driver's first line is not the token of driver.token_file")) }
}

/// Read byte by byte, because the driver's lines follow.
async fn first_line(reader: &mut (impl AsyncRead + Unpin)) -> io::Result<Vec<u8>> {
    let mut line = Vec::new();
    loop {
        match reader.read_u8().await? {
            b'\n' => return Ok(line),
            _ if line.len() >= TOKEN_LINE_MAX_BYTES => return Err(refused("the driver's first line is no token")),
            byte => line.push(byte),
        }
    }
}

/// Compares in a time that does not tell how many bytes agree.
fn is_same(one: &[u8], other: &[u8]) -> bool {
    one.len() == other.len() && one.iter().zip(other).fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
}

/// Whether a user may be the driver: the agent's own, or root.
pub(super) fn is_trusted(uid: u32) -> bool {
    uid == own_uid() || uid == 0
}

/// Refuses the peer of a loopback connection unless its socket belongs to a trusted user.
pub(super) fn expect_own_peer(peer: SocketAddr, local: SocketAddr) -> io::Result<()> {
    let table = if peer.is_ipv4() { "/proc/net/tcp" } else { "/proc/net/tcp6" };
    require_own(std::fs::read_to_string(table).ok().and_then(|table| owner_in(&table, peer, local)), peer)
}

/// Refuses the server of a loopback connection unless its socket belongs to a trusted user.
///
/// The kernel's table states user 0 for a connection until the server accepts it. So the listening socket counts; the
/// connection counts only if nobody listens there any more.
pub(super) fn expect_own_server(server: SocketAddr, local: SocketAddr) -> io::Result<()> {
    let tables = ["/proc/net/tcp", "/proc/net/tcp6"].map(|table| std::fs::read_to_string(table).unwrap_or_default());
    expect_own_server_in(&tables, server, local)
}

fn expect_own_server_in(tables: &[String; 2], server: SocketAddr, local: SocketAddr) -> io::Result<()> {
    let mut listening = tables.iter().flat_map(|table| listeners_in(table, server)).peekable();
    if listening.peek().is_none() {
        return require_own(tables.iter().find_map(|table| owner_in(table, server, local)), server);
    }
    listening.try_for_each(|uid| require_own(Some(uid), server))
}

fn require_own(owner: Option<u32>, peer: SocketAddr) -> io::Result<()> {
    match owner {
        Some(uid) if is_trusted(uid) => Ok(()),
        Some(uid) => Err(refused(&format!(
            "the driver at {peer} belongs to user {uid}: start it as the agent's user, or set driver.token_file"
        ))),
        None => Err(refused(&format!("the user of the driver at {peer} is not known: set driver.token_file"))),
    }
}

/// Local address, remote address, state and user of a line of the kernel's table.
fn fields_of(line: &str) -> Option<(&str, &str, &str, u32)> {
    let mut fields = line.split_ascii_whitespace().skip(1);
    let (local, remote, state) = (fields.next()?, fields.next()?, fields.next()?);
    // Queues, timer and retransmissions come before the user.
    Some((local, remote, state, fields.nth(3)?.parse().ok()?))
}

/// The user of the connected socket with these addresses, in the kernel's table. A socket that its program has closed has
/// user 0 there, so only an open one counts.
fn owner_in(table: &str, from: SocketAddr, to: SocketAddr) -> Option<u32> {
    let (from, to) = (in_table(from), in_table(to));
    let rows = table.lines().skip(1).filter_map(fields_of);
    let mut owners = rows.filter(|row| row.0 == from && row.1 == to && row.2 == ESTABLISHED).map(|row| row.3);
    owners.next()
}

/// The users of the sockets that listen at an address, or at all addresses with its port.
fn listeners_in(table: &str, at: SocketAddr) -> impl Iterator<Item = u32> {
    let exact = in_table(at);
    let port = format!(":{:04X}", at.port());
    let is_at = move |local: &str| {
        local == exact || local.strip_suffix(&port).is_some_and(|ip| ip.bytes().all(|digit| digit == b'0'))
    };
    table.lines().skip(1).filter_map(fields_of).filter(move |row| row.2 == LISTENS && is_at(row.0)).map(|row| row.3)
}

/// An address as in the table: words of four bytes in the machine's order, in hexadecimal.
fn in_table(address: SocketAddr) -> String {
    let bytes = match address {
        SocketAddr::V4(one) => one.ip().octets().to_vec(),
        SocketAddr::V6(one) => one.ip().octets().to_vec(),
    };
    let words = bytes.chunks_exact(4).map(|word| u32::from_ne_bytes([word[0], word[1], word[2], word[3]]));
    let ip: String = words.map(|word| format!("{word:08X}")).collect();
    format!("{ip}:{:04X}", address.port())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn only_the_token_as_the_first_line_admits() {
        for (sent, admits) in [
            ("{\"type\":\"token\",\"token\":\"s3cret\"}\n{\"type\":\"hello\"}\n", true),
            ("{\"type\":\"token\",\"token\":\"s3cret\"}\r\n", true),
            ("{\"type\":\"token\",\"token\":\"s3cre\"}\n", false),
            ("{\"type\":\"token\",\"token\":\"\"}\n", false),
            ("{\"type\":\"hello\",\"token\":\"s3cret\"}\n", false),
            ("s3cret\n", false),
            ("\n", false),
            ("{\"type\":\"token\",\"token\":\"s3cret\"}", false),
        ] {
            let mut reader = sent.as_bytes();
            assert_eq!(expect_token(&mut reader, "s3cret").await.is_ok(), admits, "{sent:?}");
        }
        let endless = vec![b'x'; 1 << 20];
        let mut reader = &endless[..];
        assert!(expect_token(&mut reader, "s3cret").await.is_err());
        assert!(reader.len() > (1 << 20) - 2000, "no more is read");
    }

    #[test]
    fn the_user_of_a_socket_is_found_in_the_kernels_table() {
        let table = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n   \
                     1: 0100007F:A125 00000000:0000 0A 00000000:00000000 00:00000000 00000000     7        0 66006 1\n   \
                     2: 0100007F:DAE4 0100007F:A125 01 00000000:00000000 00:00000000 00000000  1001        0 66007 2\n   \
                     3: 0100007F:DAE5 0100007F:A125 05 00000000:00000000 00:00000000 00000000     0        0 0 2\n   \
                     4: 00000000:A125 00000000:0000 0A 00000000:00000000 00:00000000 00000000     8        0 66008 1\n";
        let address = |text: &str| text.parse::<SocketAddr>().unwrap();
        if cfg!(target_endian = "little") {
            let owner = |from, to| owner_in(table, address(from), address(to));
            assert_eq!(owner("127.0.0.1:56036", "127.0.0.1:41253"), Some(1001));
            assert_eq!(owner("127.0.0.1:41253", "127.0.0.1:56036"), None);
            assert_eq!(owner("127.0.0.1:56037", "127.0.0.1:41253"), None, "its program has closed it");
            let listeners = |at| listeners_in(table, address(at)).collect::<Vec<_>>();
            assert_eq!(listeners("127.0.0.1:41253"), [7, 8]);
            assert_eq!(listeners("127.0.0.2:41253"), [8]);
            assert!(listeners("127.0.0.1:41254").is_empty());
            assert_eq!(in_table(address("[::1]:80")), "00000000000000000000000001000000:0050");
        }
    }

    #[test]
    fn regress_a_server_is_known_by_its_listening_socket_or_by_an_open_connection() {
        let (own, other) = (own_uid(), own_uid().max(1000) + 1);
        let (server, local): (SocketAddr, SocketAddr) =
            ("127.0.0.1:41253".parse().unwrap(), "127.0.0.1:56036".parse().unwrap());
        let row = |to: Option<SocketAddr>, state: &str, uid: u32| {
            let to = in_table(to.unwrap_or(SocketAddr::from(([0, 0, 0, 0], 0))));
            format!("0: {} {to} {state} 00000000:00000000 00:00000000 00000000 {uid} 0 1 1\n", in_table(server))
        };
        let (closing, connected) = (row(Some(local), "05", own), |uid| row(Some(local), ESTABLISHED, uid));
        for (rows, admits) in [
            (String::new(), false),
            // Nothing tells the user of a connection that its program has closed.
            (closing, false),
            (connected(own), true),
            (connected(other), false),
            (row(None, LISTENS, own), true),
            (row(None, LISTENS, other) + &connected(own), false),
        ] {
            let tables = [format!("header\n{rows}"), String::new()];
            assert_eq!(expect_own_server_in(&tables, server, local).is_ok(), admits, "{rows}");
        }
    }

    #[test]
    fn other_users_are_not_trusted() {
        assert!(is_trusted(own_uid()) && is_trusted(0) && !is_trusted(own_uid().max(1000) + 1));
    }
}
