//! The hub with an outbox on disk, without a broker and a driver.

use std::collections::BTreeMap;
use std::path::PathBuf;

use vibrissa_protocol::{Contact, Contacts, Name, Receipt, RobotTopic, decode_contacts, encode};

use super::*;
use crate::Config;
use crate::config::tests::EXAMPLE;
use crate::contract::Outgoing;
use crate::hub::boot_id;
use crate::store::spool::READ_ATTEMPTS;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("vibrissa-hub-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(path.join("outbox.spool")).unwrap();
        Self(path)
    }

    fn segment(&self, number: u64) -> PathBuf {
        self.0.join("outbox.spool").join(format!("{number:016x}"))
    }

    /// Writes a segment with one message, whose contact is deflected by so many millimetres.
    fn write(&self, number: u64) {
        let contact = Contact {
            array: Name::new("left").unwrap(),
            whisker: 0,
            t_us: 1_795_248_000_000_000,
            ratio: Some(0.8),
            ratio_sd: None,
            distance_mm: None,
            distance_sd_mm: None,
            tip: false,
            deflection_mm: number as f64,
            strain: 0.01,
            saturated: false,
            pressure_mpa: 0.1,
            temperature_c: 20.0,
            angle_deg: None,
            angle_sd_deg: None,
            test_id: None,
        };
        let message = encode(&Contacts { boot_id: boot_id(), seq: 0, contacts: vec![contact], missed: vec![] });
        let line = format!("{:08x} {}\n", crc32fast::hash(&message), String::from_utf8(message).unwrap());
        std::fs::write(self.segment(number), line).unwrap();
    }

    fn hub(&self) -> Hub {
        let mut config = Config::from_toml_str(EXAMPLE, Path::new("")).unwrap();
        config.outbox_file = Some(self.0.join("outbox"));
        Hub::start(&config).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Deflections of the contacts that the hub has published, each once: a slow test may see them sent again.
fn published(hub: &Hub) -> Vec<f64> {
    let state = hub.lock();
    let payloads = state.pending.iter().filter_map(|one| match one {
        Outgoing::Publish { topic: RobotTopic::Contacts, payload } => Some(payload),
        Outgoing::Publish { .. } | Outgoing::Restart => None,
    });
    let messages = payloads.map(|payload| decode_contacts(payload, vec![]).unwrap());
    let by_seq: BTreeMap<u64, Vec<Contact>> = messages.map(|message| (message.seq, message.contacts)).collect();
    by_seq.into_values().flatten().map(|contact| contact.deflection_mm).collect()
}

fn read_again(hub: &Hub) {
    let mut state = hub.lock();
    state.store.as_mut().unwrap().unreadable_at = None;
    hub.take_back(&mut state);
}

#[test]
fn regress_a_segment_that_cannot_be_read_costs_only_itself_and_is_counted() {
    let folder = Folder::new("unreadable");
    [2, 3].into_iter().for_each(|number| folder.write(number));
    std::fs::create_dir(folder.segment(1)).unwrap();
    let hub = folder.hub();
    hub.step(Input::Connected);
    (1..READ_ATTEMPTS).for_each(|_| {
        assert_eq!((published(&hub), hub.lock().agent.messages_dropped()), (vec![], 0));
        read_again(&hub);
    });
    assert_eq!(hub.lock().agent.messages_dropped(), 1);
    read_again(&hub);
    assert_eq!(published(&hub), [2.0, 3.0]);
    assert_eq!(hub.lock().agent.messages_dropped(), 1);
}

#[test]
fn regress_a_segment_that_can_be_read_later_is_not_lost() {
    let folder = Folder::new("later");
    [2, 3].into_iter().for_each(|number| folder.write(number));
    std::os::unix::fs::symlink("x", folder.segment(1)).unwrap();
    let hub = folder.hub();
    hub.step(Input::Connected);
    // Lines of drivers and the like do not use the attempts up.
    (0..100).for_each(|_| hub.step(Input::Tick));
    std::fs::remove_file(folder.segment(1)).unwrap();
    folder.write(1);
    read_again(&hub);
    assert_eq!((published(&hub), hub.lock().agent.messages_dropped()), (vec![1.0, 2.0, 3.0], 0));
}

#[test]
fn regress_a_backup_that_links_to_a_segment_costs_nothing() {
    let folder = Folder::new("linked");
    (1..=3).for_each(|number| folder.write(number));
    std::fs::hard_link(folder.segment(1), folder.0.join("backup")).unwrap();
    let hub = folder.hub();
    hub.step(Input::Connected);
    assert_eq!((published(&hub), hub.lock().agent.messages_dropped()), (vec![1.0, 2.0, 3.0], 0));
}

#[tokio::test]
async fn regress_a_segment_stays_until_the_file_of_the_outbox_has_its_messages() {
    let folder = Folder::new("failing");
    (1..=3).for_each(|number| folder.write(number));
    let hub = folder.hub();
    // As after a full disk: nothing is appended to the file for a while.
    hub.lock().store.as_mut().unwrap().failed_at = Some(Instant::now());
    hub.step(Input::Connected);
    assert_eq!(published(&hub), [1.0, 2.0, 3.0]);
    hub.sync().await;
    assert!((1..=3).all(|number| folder.segment(number).exists()), "a restart would lose them");
    {
        let mut state = hub.lock();
        let State { agent, store, .. } = &mut *state;
        let store = store.as_mut().unwrap();
        store.file.replace(agent.records()).unwrap();
        store.failed_at = None;
    }
    hub.sync().await;
    assert!((1..=3).all(|number| !folder.segment(number).exists()));
}

#[tokio::test]
async fn segments_free_a_full_disk_once_receipts_cover_their_messages() {
    let folder = Folder::new("full");
    (1..=3).for_each(|number| folder.write(number));
    let hub = folder.hub();
    hub.lock().store.as_mut().unwrap().failed_at = Some(Instant::now());
    hub.step(Input::Connected);
    let robot_boot_id = hub.lock().agent.boot_id().clone();
    let receipt = Receipt { boot_id: boot_id(), seq: 0, robot_boot_id, next: 3, held: vec![] };
    hub.step(Input::Message(RobotTopic::Receipt, &encode(&receipt)));
    hub.sync().await;
    assert!((1..=3).all(|number| !folder.segment(number).exists()));
}

#[tokio::test]
async fn regress_a_segment_that_cannot_be_removed_is_tried_again_with_the_next_one() {
    let folder = Folder::new("unremoved");
    folder.write(1);
    let hub = folder.hub();
    hub.step(Input::Connected);
    std::fs::remove_file(folder.segment(1)).unwrap();
    std::fs::create_dir(folder.segment(1)).unwrap();
    hub.sync().await;
    assert_eq!(hub.lock().store.as_ref().unwrap().spool.as_ref().unwrap().done(), [1]);
    std::fs::remove_dir(folder.segment(1)).unwrap();
    let mut state = hub.lock();
    let store = state.store.as_mut().unwrap();
    store.unremoved = 0;
    store.spool.as_mut().unwrap().remove(&[1]).unwrap();
    assert_eq!(store.spool.as_ref().unwrap().done(), [0; 0]);
}

/// The agent ended, and five ends later systemd gave it up.
#[test]
fn regress_a_disk_that_is_full_at_the_start_does_not_keep_the_agent_from_its_chambers() {
    let folder = Folder::new("full");
    // In place of a full disk: the new file cannot be made.
    let in_the_way = folder.0.join("outbox.new");
    std::fs::create_dir(&in_the_way).unwrap();
    let hub = folder.hub();
    let mut state = hub.lock();
    let State { agent, store: Some(store), .. } = &mut *state else { panic!("a store") };
    assert!(store.failed_at.is_some());
    std::fs::remove_dir(&in_the_way).unwrap();
    store.failed_at = Instant::now().checked_sub(STORE_AGAIN);
    store.renew(|| agent.records());
    assert!(store.failed_at.is_none());
    let stored = std::fs::read_to_string(folder.0.join("outbox")).unwrap();
    assert!(stored.starts_with("vibrissa-robot outbox 1\n"), "{stored}");
}
