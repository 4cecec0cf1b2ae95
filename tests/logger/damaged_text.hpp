#pragma once

#include <random>
#include <string>

namespace wayfare::testing {

/// A text with three places overwritten, removed or repeated, by turns with `i`.
inline std::string damaged(std::string text, int i, std::mt19937& random) {
  for (int k = 0; k < 3; ++k) {
    const std::size_t at = random() % text.size();
    if (i % 3 == 0) text[at] = static_cast<char>(random());
    if (i % 3 == 1) text.erase(at, 1 + random() % 8);
    if (i % 3 == 2) text.insert(at, text.substr(random() % text.size(), 20));
    if (text.empty()) text = "{}";
  }
  return text;
}

}  // namespace wayfare::testing
