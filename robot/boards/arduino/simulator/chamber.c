// Simulated chambers on the pins of the board.
#include <math.h>
#include <simavr/avr_adc.h>
#include <stdio.h>
#include <string.h>

#include "simulator.h"

struct chamber {
    int wired, channel, fill, vent;
    double mpa, fill_open, vent_open;
};

double supply_mpa = 0.25, sensor_volts = -1;
static struct chamber chambers[CHAMBERS];
static double analog_volts[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
static const double tau_s = 0.8;
// Mark of the inputs A8 to A15.
#define UPPER 1

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

// The library keeps the values of eight inputs. For A8 to A15 of a Mega it reads what lies behind them in memory, other in
// each run. Here they take the places of A0 to A7, and are told by the gain of their mode, which single inputs do not use.
void place_upper_inputs(avr_t *avr) {
    for (avr_io_t *io = avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, "adc")) continue;
        avr_adc_mux_t *modes = ((avr_adc_t *)io)->muxmode;
        for (int i = 0; i < 64; i++) {
            if (modes[i].kind != ADC_MUX_SINGLE || modes[i].src < 8) continue;
            modes[i].src -= 8;
            modes[i].gain = UPPER;
        }
    }
}

// Voltage at an analog input; negative, which reads as 0, if nothing is wired to it.
static double volts_of(int channel) {
    for (int i = 0; i < CHAMBERS; i++) {
        if (!chambers[i].wired || chambers[i].channel != channel) continue;
        return sensor_volts >= 0 && i == 0 ? sensor_volts : 1 + 4 * chambers[i].mpa;
    }
    // Unless it was set, the gauge of the first whisker feels its pressure a little.
    if (channel == 1 && analog_volts[1] < 0 && !chambers[1].wired) return 2.5 + 0.2 * chambers[0].mpa;
    return analog_volts[channel];
}

void set_analog_inputs(avr_irq_t *adc, uint32_t chosen) {
    union {
        avr_adc_mux_t mux;
        uint32_t v;
    } input = {.v = chosen};
    int is_upper = input.mux.kind == ADC_MUX_SINGLE && input.mux.gain == UPPER;
    for (int place = 0; place < 8; place++) {
        double volts = volts_of(is_upper ? 8 + place : place);
        avr_raise_irq(adc + ADC_IRQ_ADC0 + place, (uint32_t)lround(fmax(0, volts) * 1000));
    }
}
