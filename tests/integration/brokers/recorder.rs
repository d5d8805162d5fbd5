//! A server that records every byte it receives, before and after TLS.

use std::sync::{Arc, Mutex};

use rumqttc::tokio_rustls::TlsAcceptor;
use rumqttc::tokio_rustls::rustls::pki_types::pem::PemObject;
use rumqttc::tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rumqttc::tokio_rustls::rustls::{ServerConfig, crypto};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, DuplexStream, duplex};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinHandle;
use vibrissa_tests::certificates::Identity;

/// Bytes that clients have sent.
#[derive(Debug, Clone, Default)]
pub(crate) struct Heard {
    /// Bytes as they came over the network.
    pub(crate) wire: Vec<u8>,
    /// Bytes after decryption.
    pub(crate) plain: Vec<u8>,
    /// Number of connections.
    pub(crate) connections: usize,
}

/// A server that never answers, stopped on drop.
pub(crate) struct Recorder {
    pub(crate) port: u16,
    heard: Arc<Mutex<Heard>>,
    task: JoinHandle<()>,
}

impl Recorder {
    /// Starts the server. With an identity it completes TLS handshakes; without one it only listens.
    pub(crate) async fn start(identity: Option<&Identity>) -> Self {
        let acceptor = identity.map(acceptor);
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let heard = Arc::new(Mutex::new(Heard::default()));
        let record = heard.clone();
        let task = tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                record.lock().unwrap().connections += 1;
                tokio::spawn(serve(stream, acceptor.clone(), record.clone()));
            }
        });
        Self { port, heard, task }
    }

    /// Everything received so far.
    pub(crate) fn heard(&self) -> Heard {
        self.heard.lock().unwrap().clone()
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.task.abort();
    }
}

fn acceptor(identity: &Identity) -> TlsAcceptor {
    let certificate = CertificateDer::from_pem_slice(identity.certificate.as_bytes()).unwrap();
    let key = PrivateKeyDer::from_pem_slice(identity.key.as_bytes()).unwrap();
    let config = ServerConfig::builder_with_provider(Arc::new(crypto::ring::default_provider()))
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_no_client_auth()
        .with_single_cert(vec![certificate], key)
        .unwrap();
    TlsAcceptor::from(Arc::new(config))
}

async fn serve(stream: TcpStream, acceptor: Option<TlsAcceptor>, heard: Arc<Mutex<Heard>>) {
    let (inside, outside) = duplex(64 * 1024);
    let wire = tokio::spawn(pass(stream, outside, heard.clone()));
    match acceptor {
        Some(acceptor) => {
            if let Ok(mut stream) = acceptor.accept(inside).await {
                read(&mut stream, |bytes| heard.lock().unwrap().plain.extend_from_slice(bytes)).await;
            }
        }
        None => {
            let mut inside = inside;
            read(&mut inside, |_| {}).await;
        }
    }
    let _ = wire.await;
}

async fn read(stream: &mut (impl AsyncRead + AsyncWrite + Unpin), mut got: impl FnMut(&[u8])) {
    let mut buffer = [0; 4096];
    while let Ok(count @ 1..) = stream.read(&mut buffer).await {
        got(&buffer[..count]);
    }
}

/// Passes bytes between the network and the server and records those from the network.
async fn pass(stream: TcpStream, server: DuplexStream, heard: Arc<Mutex<Heard>>) {
    let (mut from_client, mut to_client) = stream.into_split();
    let (mut from_server, mut to_server) = tokio::io::split(server);
    let back = tokio::spawn(async move { tokio::io::copy(&mut from_server, &mut to_client).await });
    let mut buffer = [0; 4096];
    while let Ok(count @ 1..) = from_client.read(&mut buffer).await {
        heard.lock().unwrap().wire.extend_from_slice(&buffer[..count]);
        if to_server.write_all(&buffer[..count]).await.is_err() {
            break;
        }
    }
    let _ = to_server.shutdown().await;
    back.abort();
}
