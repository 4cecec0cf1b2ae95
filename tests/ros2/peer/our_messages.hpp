#pragma once

// Our messages with the values of Formula.

#include <cstdint>
#include <string>

#include <wayfare/ros/messages.hpp>

#include "formula.hpp"

namespace wayfare::testing {

/// The fields of our messages, as of ROS 2: without the sequence number of headers.
struct OurFields {
  template <class F, class M>
  static void each(F& formula, M& message) {
    Visitor<F> visitor{formula};
    M::fields(message, visitor);
  }
  template <class F>
  static void each(F& formula, ros::Stamp& stamp) {
    auto sec = static_cast<std::int32_t>(stamp.sec);
    formula(sec);
    stamp.sec = sec;
    formula(stamp.nanosec);
  }

 private:
  template <class F>
  struct Visitor {
    F& formula;
    template <class T>
    void operator()(const char*, T& value) {
      formula(value);
    }
    void ros1_only(const char*, std::uint32_t&) {}
  };
};

/// The message of a sample whose sequences have at least `size` elements.
template <class M>
[[nodiscard]] M formula_message(std::uint32_t sample, std::uint32_t size) {
  M message;
  peer::Formula<OurFields> formula(sample, size, false);
  formula(message);
  return message;
}

/// The first value that is not of that sample; empty if there is none.
template <class M>
[[nodiscard]] std::string formula_difference(M message, std::uint32_t sample, std::uint32_t size) {
  peer::Formula<OurFields> formula(sample, size, true);
  formula(message);
  return formula.difference();
}

}  // namespace wayfare::testing
