#pragma once

// Data errors and numerical failures: returned values that say where and what was expected.

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include <wayfare/core/contract.hpp>

namespace wayfare {

/// Kind of a failure, for programs; the message is for people.
enum class ErrorCode {
  io,           ///< a file or device could not be opened, read or written
  parse,        ///< bytes or text that do not follow their format
  invalid,      ///< well-formed but invalid values (NaN, indefinite matrix, bad option)
  not_found,    ///< no entry of the requested name or time
  unsupported,  ///< valid, but not handled by this version or build
  degenerate,   ///< a problem without a unique solution
  numerical,    ///< a computation failed
  cancelled,    ///< stopped on request
};

/// What failed, and where: `source` is a file or variable name, `line` counts from 1, `byte` is an
/// offset; zero or empty means "does not apply".
struct Error {
  ErrorCode code = ErrorCode::invalid;  ///< kind of failure
  std::string message;                  ///< what failed and what was expected
  std::string source = {};              ///< file or variable
  std::size_t line = 0;                 ///< from 1
  std::size_t byte = 0;                 ///< offset

  /// `source:line: message`, the form editors recognise.
  [[nodiscard]] std::string to_string() const {
    std::string text = source;
    if (line != 0) text += (text.empty() ? "line " : ":") + std::to_string(line);
    if (byte != 0) text += (text.empty() ? "byte " : ", byte ") + std::to_string(byte);
    return text.empty() ? message : text + ": " + message;
  }
};

/// Either a value or the Error that prevented it.
template <class T>
class [[nodiscard]] Result {
 public:
  using Value = T;  ///< in case of success

  /// A success.
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}  // NOLINT(*-explicit*)
  /// A failure.
  Result(Error error)
      : content_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(*-explicit*)

  /// @{
  /// Whether there is a value.
  [[nodiscard]] bool has_value() const noexcept { return content_.index() == 0; }
  explicit operator bool() const noexcept { return has_value(); }
  /// @}

  /// @{
  /// Only where there is one; else a contract is violated, with the error's message.
  [[nodiscard]] T& value() & { return expect_value(), *std::get_if<0>(&content_); }
  [[nodiscard]] const T& value() const& { return expect_value(), *std::get_if<0>(&content_); }
  [[nodiscard]] T&& value() && { return expect_value(), std::move(*std::get_if<0>(&content_)); }
  /// @}

  /// @{
  /// As value().
  [[nodiscard]] T& operator*() & { return value(); }
  [[nodiscard]] const T& operator*() const& { return value(); }
  [[nodiscard]] T&& operator*() && { return std::move(*this).value(); }
  [[nodiscard]] T* operator->() { return &value(); }
  [[nodiscard]] const T* operator->() const { return &value(); }
  /// @}

  /// Only where there is no value.
  [[nodiscard]] const Error& error() const {
    WAYFARE_EXPECTS(!has_value(), "a Result with a value has no error");
    return *std::get_if<1>(&content_);
  }

  /// The value, else `fallback`.
  [[nodiscard]] T value_or(T fallback) const& { return has_value() ? value() : fallback; }

 private:
  void expect_value() const {
    if (!has_value()) [[unlikely]]
      detail::report_violation("has_value()", std::get_if<1>(&content_)->message.c_str());
  }

  std::variant<T, Error> content_;
};

/// Success or the Error, without a value.
template <>
class [[nodiscard]] Result<void> {
 public:
  using Value = void;  ///< none

  Result() = default;
  /// A failure.
  Result(Error error) : error_(std::move(error)), failed_(true) {}  // NOLINT(*-explicit*)

  /// @{
  /// Whether it is a success.
  [[nodiscard]] bool has_value() const noexcept { return !failed_; }
  explicit operator bool() const noexcept { return has_value(); }
  /// @}

  /// Only of a failure.
  [[nodiscard]] const Error& error() const {
    WAYFARE_EXPECTS(failed_, "a successful Result has no error");
    return error_;
  }

 private:
  Error error_{};
  bool failed_ = false;
};

}  // namespace wayfare
