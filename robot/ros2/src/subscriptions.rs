//! The topics that the bridge reads, and the thread that waits for their messages.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::thread;

use futures::StreamExt;
use futures::executor::block_on;
use futures::stream::{LocalBoxStream, select_all};
use ros2_client::{MessageInfo, ReadResult, Subscription};
use serde::de::DeserializeOwned;

use crate::bridge::Input;
use crate::mapping::{MessageSeed, Value};
use crate::messages::{Contact, Fault, FluidPressure, Strain};

/// Subscriptions of the whole robot, and of its whiskers in their order.
pub(crate) struct Subscriptions {
    pub(crate) contacts: Subscription<Contact>,
    pub(crate) faults: Subscription<Fault>,
    pub(crate) pressures: Vec<Subscription<FluidPressure>>,
    pub(crate) strains: Vec<Subscription<Strain>>,
    /// Mapped topics, with the readers of their messages.
    pub(crate) mapped: Vec<(Subscription<Value>, MessageSeed)>,
}

/// Messages of a topic as inputs.
fn inputs_of<'a, M: DeserializeOwned + 'static>(
    topic: &'a Subscription<M>,
    input: impl Fn(Result<M, String>) -> Input + 'a,
) -> LocalBoxStream<'a, Input> {
    let messages = topic.async_stream();
    messages.map(move |got| input(got.map(|(message, _)| message).map_err(|problem| problem.to_string()))).boxed_local()
}

impl Subscriptions {
    /// Hands messages to the bridge until it ends. While it is busy, messages are shed: newer ones follow.
    pub(crate) fn listen(self, inputs: SyncSender<Input>, shed: Arc<AtomicU64>) {
        thread::spawn(move || {
            let mut streams = vec![inputs_of(&self.contacts, Input::Contact), inputs_of(&self.faults, Input::Fault)];
            for (index, readings) in self.pressures.iter().enumerate() {
                streams.push(inputs_of(readings, move |reading| Input::Pressure(index, reading)));
            }
            for (index, samples) in self.strains.iter().enumerate() {
                streams.push(inputs_of(samples, move |samples| Input::Strain(index, samples)));
            }
            for (index, (topic, seed)) in self.mapped.iter().enumerate() {
                let messages = topic.async_stream_seed(seed.clone());
                let input = move |got: ReadResult<(Value, MessageInfo)>| {
                    Input::Mapped(index, got.map(|(message, _)| message).map_err(|problem| problem.to_string()))
                };
                streams.push(messages.map(input).boxed_local());
            }
            let mut all = select_all(streams);
            block_on(async {
                while let Some(input) = all.next().await {
                    match inputs.try_send(input) {
                        Ok(()) => {}
                        Err(TrySendError::Full(_)) => {
                            shed.fetch_add(1, Ordering::Relaxed);
                        }
                        Err(TrySendError::Disconnected(_)) => return,
                    }
                }
            });
        });
    }
}
