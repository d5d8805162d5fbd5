use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use vibrissa_protocol::{Name, decode};

use super::*;

fn context() -> Context {
    Context {
        boot_id: "b".to_owned(),
        seq: 7,
        now_us: 1_795_248_000_000_000,
        arrays: vec![("left".to_owned(), 3), ("right".to_owned(), 1)],
        models: vec!["nguyen-2021".to_owned()],
        commands: vec!["1-2".to_owned()],
        pressures_mpa: vec![0.1],
        right_times: 0.5,
        odd_texts: 0.0,
        list_most: 8,
    }
}

#[test]
fn messages_keep_the_contract_unless_a_text_is_odd_or_an_error_is_missing() {
    let (messages, mut random) = (Messages::default(), ChaCha8Rng::seed_from_u64(1));
    let name = |text| Name::new(text).unwrap();
    for kind in FROM_ROBOTS {
        let topic = kind.of(&name("f"), &name("r"));
        let mut taken = 0;
        for _ in 0..1000 {
            let message = messages.draw(&mut random, kind, &context());
            match decode(&topic, message.as_bytes()) {
                Ok(_) => taken += 1,
                // Rules that involve several fields are not part of a schema.
                Err(refusal) => assert_ne!(refusal.label(), "not_json", "{message}"),
            }
        }
        assert!(taken > 200, "{taken} of 1000 {kind} are accepted");
    }
}

#[test]
fn the_same_seed_draws_the_same_messages() {
    let draw = |seed| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        Messages::default().draw(&mut random, RobotTopic::Contacts, &Context { list_most: 20, ..context() })
    };
    assert_eq!(draw(1), draw(1));
    assert_ne!(draw(1), draw(2));
}
