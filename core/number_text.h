#pragma once
/// Numbers in messages.
#include <cstdio>
#include <string>

namespace wick {

/// Four significant digits, whatever the size: 0.0123, 1.3e+05, 1e+300.
inline std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace wick
