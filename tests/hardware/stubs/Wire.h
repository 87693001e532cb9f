#pragma once
struct TwoWire {
  void setClock(unsigned long) {}
};
static TwoWire Wire;
