// Sensors of strain: the board's converter, an HX711 and an ADS1115.
#pragma once

#include "settings.h"

namespace vibrissa {

static const float VOLTS_PER_STEP = 5.0f / 1024.0f;

enum Sample : uint8_t {
    // Nothing new yet.
    WAITING,
    GOOD,
    // The converter is at its end: the strain is a bound.
    CLIPPED,
    // The sensor does not answer.
    ABSENT,
};

// Reads the gauge of one whisker. Nothing here waits longer than a millisecond.
class Gauge {
  public:
    void begin(const WhiskerSettings &set);
    // For each pass of the loop; `due` begins a new sample, except for an HX711, which has its own rate. `strain` is in
    // units of 1e-7.
    Sample read(const WhiskerSettings &set, bool due, int32_t &strain);

  private:
    // Samples of an HX711 that are dropped at the start: one with its first gain, and four until it has settled.
    uint8_t settling;
    bool pending;
    uint32_t since_us;

    __attribute__((noinline)) Sample read_hx711(const WhiskerSettings &set, float &volts);
    __attribute__((noinline)) Sample read_ads1115(const WhiskerSettings &set, bool due, float &volts);
};

}  // namespace vibrissa
