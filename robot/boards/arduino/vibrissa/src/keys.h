// The keys of a whisker's configuration: their names, ranges and places in the settings.
#pragma once

#include "settings.h"
#include "text.h"

namespace vibrissa {

enum KeyKind : uint8_t {
    NAME, NUMBER_OF_WHISKER, VALVE_PIN, DIGITAL_PIN, ANALOG_PIN, REAL, SIGNED,
    SENSOR_WORD, GAIN, ADDRESS, INPUTS, RANGE, RATE,
};

struct Key {
    char name[19];
    KeyKind kind;
    uint8_t offset;
    float low, high;
};

static const uint8_t KEYS = 21;

// In the flash: copy a key with memcpy_P. 0 if there is none of this name.
const Key *find_key(Part name);
__attribute__((noinline)) bool take_value(const Key &in_flash, Part value, WhiskerSettings &set);
// The allowed values, in words.
__attribute__((noinline)) void put_allowed(const Key &in_flash);
// `,"key":value`
__attribute__((noinline)) void put_value(uint8_t key, const WhiskerSettings &set);

}  // namespace vibrissa
