//! Waits for a robot that is not connected yet.

use std::time::Duration;

use anyhow::bail;
use vibrissa_protocol::{ConnectionState, Message, Name, RobotTopic, Topic, decode};

use super::report::seconds;
use vibrissa_supervisor::mqtt::{Connection, TestClient};

/// Time limit for the factsheet, which follows the birth. Its absence is a finding of the check.
const FACTSHEET_WITHIN: Duration = Duration::from_secs(2);

/// Waits until the robot has published its birth and its factsheet. `address` is the one to which it must connect.
///
/// # Errors
/// The connection to the broker fails, or the robot does not connect within the limit.
pub async fn wait_for_robot(
    connection: &Connection,
    robot: &Name,
    limit: Duration,
    address: &str,
) -> anyhow::Result<()> {
    let fleet = &connection.fleet;
    let topics = [RobotTopic::Connection, RobotTopic::Factsheet].map(|kind| kind.of(fleet, robot).to_string());
    let mut client = TestClient::open(connection, &topics).await?;
    if let Ok(born) = tokio::time::timeout(limit, heard(&mut client, is_birth)).await {
        born?;
        let factsheet = heard(&mut client, |message| matches!(message, Message::Factsheet(_)));
        if let Ok(ended) = tokio::time::timeout(FACTSHEET_WITHIN, factsheet).await {
            ended?;
        }
        client.close().await;
        return Ok(());
    }
    bail!(
        "robot {fleet}/{robot} did not connect to the broker {} within {}: is it on, is this the broker's address in \
         its settings, and are these its names? It must publish {} with ONLINE",
        address,
        seconds(limit),
        topics[0]
    )
}

fn is_birth(message: &Message) -> bool {
    matches!(message, Message::Connection(connection) if connection.state == ConnectionState::Online)
}

async fn heard(client: &mut TestClient, is_it: impl Fn(&Message) -> bool) -> anyhow::Result<()> {
    loop {
        let said = client.next().await?;
        let Ok(topic) = Topic::parse(&said.topic) else { continue };
        if decode(&topic, &said.payload).is_ok_and(|message| is_it(&message)) {
            return Ok(());
        }
    }
}
