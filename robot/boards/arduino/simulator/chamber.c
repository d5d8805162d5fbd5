// Simulated chambers on the pins of the board.
#include <math.h>
#include <simavr/avr_adc.h>
#include <stdio.h>

#include "simulator.h"

struct chamber {
    int wired, channel, fill, vent;
    double mpa, fill_open, vent_open;
};

double supply_mpa = 0.25, sensor_volts = -1;
static struct chamber chambers[CHAMBERS];
static double analog_volts[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
static const double tau_s = 0.8;

double chamber_mpa(int chamber) { return chambers[chamber].mpa; }

void set_volts(int channel, double volts) { analog_volts[channel & 15] = volts; }

static void on_valve(avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq;
    *(int *)param = value & 1;
    for (int i = 0; i < CHAMBERS; i++) {
        struct chamber *c = &chambers[i];
        if (param != &c->fill && param != &c->vent) continue;
        printf("%.1f %.5f valves %d %d", now_ms(), c->mpa, c->fill, c->vent);
        // The first chamber has no number.
        if (i) printf(" of %d", i);
        printf("\n");
    }
}

void wire_chamber(int number, int fill_pin, int vent_pin, int channel) {
    struct chamber *c = &chambers[number];
    c->wired = 1;
    c->channel = channel;
    avr_irq_register_notify(pin_irq(fill_pin), on_valve, &c->fill);
    avr_irq_register_notify(pin_irq(vent_pin), on_valve, &c->vent);
}

static double orifice(double from_mpa, double to_mpa) {
    double from = from_mpa + 0.1013, to = to_mpa + 0.1013, sign = from > to ? 1 : -1;
    double up = fmax(from, to), ratio = fmin(from, to) / up;
    return sign * up * (ratio < 0.528 ? 1 : sqrt(fmax(0, 1 - pow((ratio - 0.528) / 0.472, 2))));
}

// A valve opens in 5 ms and closes in 3 ms.
static double towards(double position, int open, double seconds) {
    return fmin(1, fmax(0, position + (open ? seconds / 0.005 : -seconds / 0.003)));
}

void move_air(double seconds) {
    for (int i = 0; i < CHAMBERS; i++) {
        struct chamber *c = &chambers[i];
        if (!c->wired) continue;
        c->fill_open = towards(c->fill_open, c->fill, seconds);
        c->vent_open = towards(c->vent_open, c->vent, seconds);
        double rate = c->fill_open * orifice(supply_mpa, c->mpa) + c->vent_open * orifice(0, c->mpa);
        c->mpa += rate / tau_s * seconds;
    }
}

void set_analog_inputs(avr_irq_t *adc) {
    // The library simulates eight of the sixteen inputs of a Mega.
    for (int channel = 0; channel < 8; channel++) {
        if (analog_volts[channel] >= 0) {
            avr_raise_irq(adc + ADC_IRQ_ADC0 + channel, (uint32_t)lround(analog_volts[channel] * 1000));
        }
    }
    for (int i = 0; i < CHAMBERS; i++) {
        if (!chambers[i].wired) continue;
        double volts = sensor_volts >= 0 && i == 0 ? sensor_volts : 1 + 4 * chambers[i].mpa;
        avr_raise_irq(adc + ADC_IRQ_ADC0 + chambers[i].channel, (uint32_t)lround(volts * 1000));
    }
    // Unless it was set, the gauge of the first whisker feels its pressure a little.
    if (analog_volts[1] < 0 && !chambers[1].wired) {
        avr_raise_irq(adc + ADC_IRQ_ADC1, 2500 + (uint32_t)lround(200 * chambers[0].mpa));
    }
}
