//! Connections over byte streams, by the codec of rumqttc.

use std::io;

use bytes::BytesMut;
use rumqttc::{Error, Packet};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, split};
use tokio::net::TcpListener;

use super::ModelBroker;
use super::port::ClientPort;

impl ModelBroker {
    /// Serves a client on a byte stream until one side ends the connection. Dropping the future breaks it.
    ///
    /// # Errors
    /// The broker accepts no connections, the stream breaks, or the client sends something that is not MQTT 5.
    pub async fn serve<S: AsyncRead + AsyncWrite>(&self, stream: S) -> io::Result<()> {
        let port = ClientPort::open(self, None).ok_or(io::ErrorKind::ConnectionRefused)?;
        let (reader, writer) = split(stream);
        tokio::select! {
            biased;
            ended = read(&port, reader) => ended,
            ended = write(&port, writer) => ended,
        }
    }

    /// Serves TCP connections in real time, to compare this broker with real ones. Ends only with an error.
    ///
    /// # Errors
    /// The listener fails.
    pub async fn listen(&self, listener: TcpListener) -> io::Result<()> {
        loop {
            let (stream, _) = listener.accept().await?;
            stream.set_nodelay(true)?;
            let broker = self.clone();
            vibrissa_host::task::spawn(async move { broker.serve(stream).await });
        }
    }
}

async fn read(port: &ClientPort, mut reader: impl AsyncRead + Unpin) -> io::Result<()> {
    let mut bytes = BytesMut::new();
    loop {
        match Packet::read(&mut bytes, None) {
            Ok(packet) => port.send(packet),
            Err(Error::InsufficientBytes(_)) => {
                if reader.read_buf(&mut bytes).await? == 0 {
                    return Ok(());
                }
            }
            Err(problem) => return Err(io::Error::new(io::ErrorKind::InvalidData, problem)),
        }
    }
}

/// Writes all packets that have arrived at once.
async fn write(port: &ClientPort, mut writer: impl AsyncWrite + Unpin) -> io::Result<()> {
    let mut bytes = BytesMut::new();
    while let Some(first) = port.next().await {
        encode(&first, &mut bytes)?;
        while let Some(Some(packet)) = port.try_next() {
            encode(&packet, &mut bytes)?;
        }
        writer.write_all_buf(&mut bytes).await?;
        writer.flush().await?;
    }
    writer.shutdown().await
}

fn encode(packet: &Packet, bytes: &mut BytesMut) -> io::Result<()> {
    packet.write(bytes, None).map(drop).map_err(|problem| io::Error::new(io::ErrorKind::InvalidInput, problem))
}
