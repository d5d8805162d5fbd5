// Converters on the pins of the board: HX711 and ADS1115, as their data sheets describe them.
#include <math.h>
#include <simavr/avr_twi.h>
#include <simavr/sim_cycle_timers.h>
#include <string.h>

#include "simulator.h"

struct hx711 {
    int wired, data_pin, broken;
    double rate_hz, volts, ready_ms, high_ms;
    // Bits and pulses of the running transmission, and gain of the next conversion.
    uint32_t bits;
    int pulses, shifting, gain, level, settling;
};

struct ads1115 {
    int wired, address;
    double volts[4], done_ms;
    uint16_t config, conversion;
    uint8_t pointer, byte;
};

static struct hx711 hx711s[DEVICES];
static struct ads1115 ads1115s[DEVICES];
static struct ads1115 *addressed;
static avr_irq_t *to_master;

static void hx711_level(struct hx711 *chip, int level) {
    chip->level = level;
    set_pin(chip->data_pin, chip->broken ? chip->broken - 1 : level);
}

// After a reset or power-down: channel A with a gain of 128, and four conversions until it has settled.
static void hx711_reset(struct hx711 *chip) {
    chip->gain = 128;
    chip->pulses = chip->shifting = 0;
    chip->settling = 3;
    chip->ready_ms = now_ms() + 1000 / chip->rate_hz;
    hx711_level(chip, 1);
}

static void hx711_clock(avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq;
    struct hx711 *chip = param;
    if (!(value & 1)) {
        if (now_ms() - chip->high_ms > 0.060) hx711_reset(chip);
        return;
    }
    chip->high_ms = now_ms();
    if (!chip->shifting && !chip->level) {
        chip->shifting = 1;
        chip->pulses = 0;
        double scaled = chip->volts * chip->gain / 2.5 * 8388608;
        // A chip that has not settled tells something else.
        if (chip->settling > 0) scaled = 8388607;
        chip->bits = (uint32_t)(int32_t)fmax(-8388608, fmin(8388607, round(scaled))) & 0xffffff;
    }
    if (!chip->shifting) return;
    chip->pulses++;
    if (chip->pulses <= 24) hx711_level(chip, chip->bits >> (24 - chip->pulses) & 1);
    if (chip->pulses >= 25) hx711_level(chip, 1);
}

// The next conversion is complete, with the gain that the pulses of the last transmission have chosen.
static void hx711_convert(struct hx711 *chip) {
    if (chip->pulses >= 25) {
        int gain = chip->pulses == 25 ? 128 : chip->pulses == 26 ? 32 : 64;
        chip->settling = gain != chip->gain ? 3 : chip->settling - (chip->settling > 0);
        chip->gain = gain;
    }
    // Data that were not fetched are replaced.
    chip->pulses = chip->shifting = 0;
    hx711_level(chip, 0);
}

void wire_hx711(int device, int data_pin, int clock_pin, double rate_hz) {
    struct hx711 *chip = &hx711s[device];
    chip->wired = 1;
    chip->data_pin = data_pin;
    chip->rate_hz = rate_hz;
    hx711_reset(chip);
    avr_irq_register_notify(pin_irq(clock_pin), hx711_clock, chip);
}

void set_hx711(int device, double volts) { hx711s[device].volts = volts; }

void break_hx711(int device, int level) {
    hx711s[device].broken = 1 + level;
    hx711_level(&hx711s[device], level);
}

static void ads1115_convert(struct ads1115 *chip) {
    static const double ranges[8] = {6.144, 4.096, 2.048, 1.024, 0.512, 0.256, 0.256, 0.256};
    static const int positive[8] = {0, 0, 1, 2, 0, 1, 2, 3}, negative[8] = {1, 3, 3, 3, -1, -1, -1, -1};
    int inputs = chip->config >> 12 & 7;
    double volts = chip->volts[positive[inputs]] - (negative[inputs] < 0 ? 0 : chip->volts[negative[inputs]]);
    double scaled = round(volts / ranges[chip->config >> 9 & 7] * 32768);
    chip->conversion = (uint16_t)(int16_t)fmax(-32768, fmin(32767, scaled));
}

static void ads1115_write(struct ads1115 *chip, uint8_t data) {
    static const double rates[8] = {8, 16, 32, 64, 128, 250, 475, 860};
    if (chip->byte == 0) {
        chip->pointer = data & 3;
    } else if (chip->pointer == 1 && chip->byte == 1) {
        chip->config = (chip->config & 0x00ff) | data << 8;
    } else if (chip->pointer == 1 && chip->byte == 2) {
        chip->config = (chip->config & 0xff00) | data;
        if (chip->config & 0x8000) chip->done_ms = now_ms() + 1000 / rates[chip->config >> 5 & 7] * 1.1 + 0.03;
    }
    chip->byte++;
}

static uint8_t ads1115_read(struct ads1115 *chip) {
    uint16_t value = chip->pointer ? chip->config : chip->conversion;
    return chip->byte++ ? value & 0xff : value >> 8;
}

static void on_twi(avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)param;
    avr_twi_msg_irq_t message = {.u = {.v = value}};
    uint8_t what = message.u.twi.msg;
    if (what & TWI_COND_STOP) addressed = NULL;
    if (what & TWI_COND_START) {
        addressed = NULL;
        for (int i = 0; i < DEVICES; i++) {
            if (ads1115s[i].wired && ads1115s[i].address == message.u.twi.addr >> 1) addressed = &ads1115s[i];
        }
        if (!addressed) return;
        addressed->byte = 0;
        avr_raise_irq(to_master, avr_twi_irq_msg(TWI_COND_ACK, message.u.twi.addr, 1));
    }
    if (!addressed) return;
    if (what & TWI_COND_WRITE) {
        avr_raise_irq(to_master, avr_twi_irq_msg(TWI_COND_ACK, message.u.twi.addr, 1));
        ads1115_write(addressed, message.u.twi.data);
    }
    if (what & TWI_COND_READ) {
        avr_raise_irq(to_master, avr_twi_irq_msg(TWI_COND_READ, message.u.twi.addr, ads1115_read(addressed)));
    }
}

void wire_ads1115(int device, int address) {
    struct ads1115 *chip = &ads1115s[device];
    chip->wired = 1;
    chip->address = address;
    chip->config = 0x8583;
    if (to_master) return;
    // Version 1.6 of the library keeps TWINT set although the program writes a one to it.
    for (avr_io_t *io = avr->io_port; io; io = io->next) {
        if (!strcmp(io->kind, "twi")) ((avr_twi_t *)io)->twi.raise_sticky = 0;
    }
    to_master = avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_INPUT);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_OUTPUT), on_twi, NULL);
}

void set_ads1115(int device, int input, double volts) { ads1115s[device].volts[input & 3] = volts; }

void run_devices(void) {
    for (int i = 0; i < DEVICES; i++) {
        struct hx711 *chip = &hx711s[i];
        if (chip->wired && now_ms() >= chip->ready_ms) {
            chip->ready_ms += 1000 / chip->rate_hz;
            hx711_convert(chip);
        }
        struct ads1115 *adc = &ads1115s[i];
        if (adc->done_ms > 0 && now_ms() >= adc->done_ms) {
            adc->done_ms = 0;
            ads1115_convert(adc);
        }
    }
}
