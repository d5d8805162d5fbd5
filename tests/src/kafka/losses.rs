//! Losses of a log: records deleted by its retention, and a topic that somebody creates anew.

use rskafka::client::partition::OffsetAt;

use super::clients::partition_client;
use super::{ANSWER, Kafka, START};
use crate::wait::until_within;

impl Kafka {
    /// Deletes all records that a partition has now, as retention does with old ones.
    ///
    /// # Panics
    /// The brokers do not delete them.
    pub async fn delete_records(&self, topic: &str, partition: u32) {
        until_within(START, "the deletion of records", async || {
            let client = partition_client(&self.client().await, topic, partition).await?;
            let latest = tokio::time::timeout(ANSWER, client.get_offset(OffsetAt::Latest)).await.ok()?.ok()?;
            tokio::time::timeout(ANSWER, client.delete_records(latest, 5000)).await.ok()?.ok()
        })
        .await;
    }

    /// Deletes a topic with its records, and creates it without any.
    ///
    /// # Panics
    /// The brokers do not do it.
    pub async fn create_topic_anew(&self, name: &str, partitions: u32) {
        until_within(START, "the deletion of a topic", async || {
            let client = self.client().await;
            let controller = client.controller_client().ok()?;
            let _ = tokio::time::timeout(ANSWER, controller.delete_topic(name, 5000)).await;
            let topics = tokio::time::timeout(ANSWER, client.list_topics()).await.ok()?.ok()?;
            (!topics.iter().any(|topic| topic.name == name)).then_some(())
        })
        .await;
        self.create_topic(name, partitions).await;
    }
}
