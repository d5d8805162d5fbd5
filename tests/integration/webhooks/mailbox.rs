//! A mail server that keeps the mails it gets, and answers as a test tells it.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};

use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
use tokio::net::{TcpListener, TcpStream};

/// A mail: the address that it is for, headers and text.
#[derive(Debug, Clone)]
pub(crate) struct Mail {
    pub(crate) to: String,
    pub(crate) headers: String,
    pub(crate) text: String,
}

impl Mail {
    /// The value of a header, with its lines joined; empty without such a header.
    pub(crate) fn header(&self, name: &str) -> String {
        let joined = self.headers.replace("\r\n ", " ");
        let line = joined.lines().find_map(|line| line.strip_prefix(&format!("{name}: ")));
        line.unwrap_or_default().to_owned()
    }
}

/// A running mail server; its tasks end with the test's runtime.
#[derive(Clone)]
pub(crate) struct Mailbox {
    pub(crate) address: SocketAddr,
    /// Answer to each recipient.
    answer: Arc<Mutex<&'static str>>,
    /// Mails, and the number of recipients that were refused.
    state: Arc<Mutex<(Vec<Mail>, usize)>>,
}

impl Mailbox {
    pub(crate) async fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let mailbox = Self { address, answer: Arc::new(Mutex::new("250 fine")), state: Arc::default() };
        let serving = mailbox.clone();
        tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                let mailbox = serving.clone();
                tokio::spawn(async move { mailbox.converse(stream).await });
            }
        });
        mailbox
    }

    async fn converse(&self, stream: TcpStream) -> std::io::Result<()> {
        let mut stream = BufReader::new(stream);
        stream.write_all(b"220 mail.example\r\n").await?;
        let mut to = String::new();
        loop {
            let mut line = String::new();
            if stream.read_line(&mut line).await? == 0 {
                return Ok(());
            }
            let answer = match line.get(..4).unwrap_or_default() {
                "RCPT" => {
                    to = line.split(['<', '>']).nth(1).unwrap_or_default().to_owned();
                    let answer = *self.answer.lock().unwrap_or_else(PoisonError::into_inner);
                    if !answer.starts_with("250") {
                        self.state.lock().unwrap_or_else(PoisonError::into_inner).1 += 1;
                    }
                    answer
                }
                "DATA" => {
                    stream.write_all(b"354 go on\r\n").await?;
                    let mut data = String::new();
                    while !data.ends_with("\r\n.\r\n") {
                        if stream.read_line(&mut data).await? == 0 {
                            return Ok(());
                        }
                    }
                    let (headers, text) = data.split_once("\r\n\r\n").unwrap_or_default();
                    let mail = Mail { to: to.clone(), headers: headers.to_owned(), text: text.to_owned() };
                    self.state.lock().unwrap_or_else(PoisonError::into_inner).0.push(mail);
                    "250 taken"
                }
                "QUIT" => "221 bye",
                _ => "250 fine",
            };
            stream.write_all(format!("{answer}\r\n").as_bytes()).await?;
        }
    }

    /// Sets the answer to each recipient from now on.
    pub(crate) fn answers(&self, answer: &'static str) {
        *self.answer.lock().unwrap_or_else(PoisonError::into_inner) = answer;
    }

    /// All mails so far.
    pub(crate) fn mails(&self) -> Vec<Mail> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).0.clone()
    }

    /// Number of recipients that were refused so far.
    pub(crate) fn refused(&self) -> usize {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).1
    }
}
