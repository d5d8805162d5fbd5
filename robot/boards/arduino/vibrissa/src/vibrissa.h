// A board of vibrissa: whiskers with two on/off valves, a pressure sensor and a strain gauge each, for an Arduino Uno
// (two whiskers) or Mega (six). It speaks the driver interface of vibrissa-robot over serial.
//
// Call begin() in setup(), and loop() in loop() without a pause. `Regulator` of regulator.h can be used alone.
#pragma once

#include "regulator.h"

// Also in library.properties.
#define VIBRISSA_VERSION "0.2.0"

namespace vibrissa {

void begin();
void loop();

}  // namespace vibrissa
