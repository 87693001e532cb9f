// The parts of Arduino that the sketch uses, with a clock that the test sets.
#pragma once
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PROGMEM
#define F(text) text
#define HIGH 1
#define LOW 0
#define INPUT_PULLUP 2
#define constrain(x, low, high) ((x) < (low) ? (low) : ((x) > (high) ? (high) : (x)))
#define pgm_read_byte(address) (*(const uint8_t *)(address))
#define pgm_read_word(address) (*(const uint16_t *)(address))

static uint32_t clock_ms = 0;
static bool button_down = false;
inline uint32_t millis() { return clock_ms; }
inline uint32_t micros() { return clock_ms * 1000; }
inline void pinMode(uint8_t, uint8_t) {}
inline int analogRead(uint8_t) { return 0; }
inline int digitalRead(uint8_t) { return button_down ? LOW : HIGH; }

struct SerialPort {
  const char *waiting = "";
  size_t bytes = 0;  // number of waiting bytes, if they may be 0
  void begin(long) {}
  int available() { return bytes ? bytes : strlen(waiting); }
  char read() {
    if (bytes) bytes--;
    return *waiting++;
  }
  void write(const uint8_t *out, size_t count) {
    printf("reply %u ", clock_ms);
    for (size_t i = 0; i < count; i++) printf("%02x", out[i]);
    printf("\n");
  }
  void println(const char *) {}
};
static SerialPort Serial;
