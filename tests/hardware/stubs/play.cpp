// Runs a sketch: SECONDS, then pairs of a second and a command; b presses the button for 100 ms.
#include <stdlib.h>
#include SKETCH

int main(int count, char **words) {
  setup();
  const uint32_t end = atof(words[1]) * 1000;
  uint32_t up = 0;
  for (clock_ms = 0; clock_ms <= end; clock_ms++) {
    for (int word = 2; word + 1 < count; word += 2) {
      if (clock_ms != (uint32_t)(atof(words[word]) * 1000)) continue;
      if (*words[word + 1] == 'b') {
        button_down = true;
        up = clock_ms + 100;
      } else {
        Serial.waiting = words[word + 1];
      }
    }
    if (clock_ms == up) button_down = false;
    loop();
  }
}
