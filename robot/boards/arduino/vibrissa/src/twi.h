// The I2C bus, 400 kHz, without interrupts and buffers: Wire takes 200 bytes of memory.
#pragma once

#include <stdint.h>

namespace vibrissa {

void begin_twi();
// A register of 16 bits. False if the device does not answer; the bus is then free again.
bool write_register(uint8_t address, uint8_t which, uint16_t value);
bool read_register(uint8_t address, uint8_t which, int16_t &value);

}  // namespace vibrissa
