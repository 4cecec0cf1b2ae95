#pragma once

// Archives over the fields of a message: one writes, one reads. CDR and ROS 1 differ only in
// alignment and in how strings end.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/ros/messages.hpp>

namespace wayfare::ros {

struct Encoding {
  bool big_endian = false;
  std::size_t max_align = 1;         ///< 1: packed
  bool texts_end_with_zero = false;  ///< counted in their length
  bool has_seq = true;               ///< of headers
};

using decode::Number;

/// Padding at `at` so that a number of `size` bytes is aligned as the encoding requires.
[[nodiscard]] inline std::size_t padding(const Encoding& encoding, std::size_t at,
                                         std::size_t size) {
  const std::size_t align = size < encoding.max_align ? size : encoding.max_align;
  return (align - at % align) % align;
}

class Writer {
 public:
  explicit Writer(Encoding encoding) : encoding_(encoding) {}

  template <class T>
  void operator()(const char*, const T& value) {
    put(value);
  }
  void ros1_only(const char*, std::uint32_t value) {
    if (encoding_.has_seq) put(value);
  }
  [[nodiscard]] std::string take() { return std::move(out_); }

 private:
  template <Number T>
  void put(T value) {
    out_.append(padding(encoding_, out_.size(), sizeof(T)), '\0');
    std::uint8_t bytes[sizeof(T)];
    encoding_.big_endian ? decode::store_be(value, bytes) : decode::store_le(value, bytes);
    out_.append(bytes, bytes + sizeof(T));
  }
  void put(bool value) { put(static_cast<std::uint8_t>(value ? 1 : 0)); }
  void put(const Stamp& stamp) {
    put(static_cast<std::uint32_t>(stamp.sec));
    put(stamp.nanosec);
  }
  void put(const std::string& text) {
    const std::size_t zero = encoding_.texts_end_with_zero ? 1 : 0;
    put(static_cast<std::uint32_t>(text.size() + zero));
    out_ += text;
    out_.append(zero, '\0');
  }
  template <class T>
  void put(const std::vector<T>& list) {
    put(static_cast<std::uint32_t>(list.size()));
    if constexpr (sizeof(T) == 1 && Number<T>) {
      out_.append(reinterpret_cast<const char*>(list.data()), list.size());
    } else {
      for (const T& item : list) put(item);
    }
  }
  template <class T, std::size_t N>
  void put(const std::array<T, N>& list) {
    for (const T& item : list) put(item);
  }
  template <class M>
  requires requires { M::kType; }
  void put(const M& message) { M::fields(message, *this); }

  Encoding encoding_;
  std::string out_;
};

/// Past the end all values are unchanged and `ok` is false.
class Reader {
 public:
  Reader(std::string_view bytes, Encoding encoding) : bytes_(bytes), encoding_(encoding) {}

  template <class T>
  void operator()(const char* name, T& value) {
    if (!ok_) return;
    get(value);
    if (!ok_ && failed_at_ == nullptr) failed_at_ = name;
  }
  void ros1_only(const char* name, std::uint32_t& value) {
    if (encoding_.has_seq) (*this)(name, value);
  }
  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  /// The field at which the bytes ended.
  [[nodiscard]] const char* failed_at() const { return failed_at_; }

 private:
  [[nodiscard]] std::string_view take(std::size_t n) {
    if (n > left()) {
      ok_ = false;
      return {};
    }
    at_ += n;
    return bytes_.substr(at_ - n, n);
  }
  template <Number T>
  void get(T& value) {
    static_cast<void>(take(padding(encoding_, at_, sizeof(T))));
    const std::string_view from = take(sizeof(T));
    if (!ok_) return;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(from.data());
    value = encoding_.big_endian ? decode::load_be<T>(bytes) : decode::load_le<T>(bytes);
  }
  void get(bool& value) {
    std::uint8_t byte = 0;
    get(byte);
    value = byte != 0;
  }
  void get(Stamp& stamp) {
    std::uint32_t sec = 0;
    get(sec);
    get(stamp.nanosec);
    // ROS 2 has the range 1901 to 2038; ROS 1 starts in 1970.
    stamp.sec =
        encoding_.has_seq ? std::int64_t{sec} : std::int64_t{static_cast<std::int32_t>(sec)};
  }
  void get(std::string& text) {
    std::uint32_t size = 0;
    get(size);
    std::string_view from = take(size);
    if (encoding_.texts_end_with_zero && !from.empty()) {
      if (from.back() != '\0') ok_ = false;
      from.remove_suffix(1);
    }
    text = from;
  }
  template <class T>
  void get(std::vector<T>& list) {
    std::uint32_t size = 0;
    get(size);
    if (!ok_) return;
    if constexpr (Number<T>) {
      // No more memory than there are bytes to fill it.
      if (size > left() / sizeof(T)) {
        ok_ = false;
        return;
      }
      list.resize(size);
      for (T& item : list) get(item);
    } else {
      for (std::uint32_t i = 0; i < size && ok_; ++i) get(list.emplace_back());
    }
  }
  template <class T, std::size_t N>
  void get(std::array<T, N>& list) {
    for (T& item : list) get(item);
  }
  template <class M>
  requires requires { M::kType; }
  void get(M& message) { M::fields(message, *this); }

  std::string_view bytes_;
  Encoding encoding_;
  std::size_t at_ = 0;
  bool ok_ = true;
  const char* failed_at_ = nullptr;
};

}  // namespace wayfare::ros
