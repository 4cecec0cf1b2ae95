#pragma once

// The command port of a TI mmWave sensor: a configuration (.cfg) sent line by line, each after the
// answer to the one before. The sensor echoes a line, answers "Done", "Error" with a number, or
// that it does not know the command, and prints a prompt that ends with ":/>".

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>

namespace wayfare::decode {

/// The conversation about one configuration. Does no input or output.
class TiDialogue {
 public:
  /// `config` must outlive this; `source` names it in errors.
  TiDialogue(std::string_view config, std::string source);

  /// The next command without its newline, once the one before is answered; nullopt while an answer
  /// is awaited, after an error, and at the end. Comments and empty lines are not sent.
  [[nodiscard]] std::optional<std::string_view> next();
  /// Takes what the port sent.
  void feed(std::string_view received);
  /// Whether every command was answered without an error.
  [[nodiscard]] bool is_done() const { return !waiting_ && !error_ && rest_.empty(); }
  /// The command that failed, with its line and the answer; nullopt without a failure.
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }
  /// The error of an answer that does not come.
  [[nodiscard]] Error no_answer() const;
  /// Number of commands answered.
  [[nodiscard]] std::size_t answered() const { return answered_; }

 private:
  void skip_to_command();
  void judge();

  std::string_view rest_;  ///< from the next command on
  std::string source_, answer_;
  std::string_view command_;  ///< being answered
  std::size_t line_ = 1,      ///< of the beginning of `rest_`
      command_line_ = 0;
  bool waiting_ = false;
  std::size_t answered_ = 0;
  std::optional<Error> error_;
};

}  // namespace wayfare::decode
