//! Partitions that are added to a topic. The client of the tests cannot do it, so the request is made here.

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use super::{ANSWER, Kafka, START};
use crate::wait::until_within;

/// Number of the request `CreatePartitions`.
const CREATE_PARTITIONS: i16 = 37;
/// Its version.
const VERSION: i16 = 3;

impl Kafka {
    /// Gives a topic so many partitions, more than it has.
    ///
    /// # Panics
    /// The brokers do not add them.
    pub async fn raise_partitions(&self, topic: &str, count: u32) {
        until_within(START, "new partitions", async || {
            let asked = tokio::time::timeout(ANSWER, ask(&self.addresses()[0], request(topic, count))).await;
            let topics = tokio::time::timeout(ANSWER, self.client().await.list_topics()).await.ok()?.ok()?;
            let is_raised = topics.iter().any(|one| one.name == topic && one.partitions.len() == count as usize);
            if !is_raised {
                eprintln!("topic {topic}: {asked:?}");
            }
            is_raised.then_some(())
        })
        .await;
    }
}

/// The request with its length in front.
fn request(topic: &str, count: u32) -> Vec<u8> {
    const CLIENT: &str = "tests";
    const NO_TAGS: u8 = 0;
    let mut bytes = Vec::new();
    bytes.extend(CREATE_PARTITIONS.to_be_bytes());
    bytes.extend(VERSION.to_be_bytes());
    bytes.extend(1_i32.to_be_bytes());
    bytes.extend((CLIENT.len() as i16).to_be_bytes());
    bytes.extend(CLIENT.as_bytes());
    bytes.push(NO_TAGS);
    // One topic; lengths are one more than they are. The brokers choose the replicas.
    bytes.push(2);
    bytes.push(topic.len() as u8 + 1);
    bytes.extend(topic.as_bytes());
    bytes.extend((count as i32).to_be_bytes());
    bytes.extend([0, NO_TAGS]);
    bytes.extend(5000_i32.to_be_bytes());
    bytes.extend([0, NO_TAGS]);
    [&(bytes.len() as i32).to_be_bytes()[..], &bytes].concat()
}

/// The answer to a request.
async fn ask(address: &str, request: Vec<u8>) -> std::io::Result<Vec<u8>> {
    let mut stream = TcpStream::connect(address).await?;
    stream.write_all(&request).await?;
    let mut answer = vec![0; stream.read_i32().await? as usize];
    stream.read_exact(&mut answer).await?;
    Ok(answer)
}
