// Parts of the simulated board.
#pragma once

#include <simavr/sim_avr.h>
#include <simavr/sim_irq.h>

#define MHZ 16
#define CHAMBERS 6
#define DEVICES 6

extern avr_t *avr;
extern int is_mega;

double now_ms(void);
// The irq of a digital pin by its Arduino number.
avr_irq_t *pin_irq(int pin);
void set_pin(int pin, int level);

// chamber.c: simulated chambers, each with two valves and a sensor on an analog input.
extern double supply_mpa, sensor_volts;
void wire_chamber(int chamber, int fill_pin, int vent_pin, int channel);
void move_air(double seconds);
double chamber_mpa(int chamber);
// Called before a conversion of the microcontroller, with the input that it has chosen.
void set_analog_inputs(avr_irq_t *adc, uint32_t chosen);
void place_upper_inputs(avr_t *avr);
void set_volts(int channel, double volts);

// devices.c: converters beside the microcontroller.
void wire_hx711(int device, int data_pin, int clock_pin, double rate_hz);
// Volts between the inputs of channel A.
void set_hx711(int device, double volts);
// A chip that does not answer: its data line is floating or low.
void break_hx711(int device, int level);
void wire_ads1115(int device, int address);
void set_ads1115(int device, int input, double volts);
void run_devices(void);
