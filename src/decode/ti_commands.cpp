#include <wayfare/decode/ti_commands.hpp>

#include <algorithm>
#include <utility>

#include "decode/trimmed.hpp"

namespace wayfare::decode {
namespace {

constexpr std::string_view kPrompt = ":/>";
constexpr std::size_t kLongestAnswer = 4096;

/// Calls `f` with the lines of a text, trimmed.
template <class F>
void for_each_line(std::string_view text, F&& f) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    f(trimmed(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

bool reports_error(std::string_view line) {
  return line.starts_with("Error") || line.ends_with("is not recognized as a CLI command");
}

bool reports_success(std::string_view line) {
  return line.starts_with("Done") || line.starts_with("Skipped") || line.starts_with("Ignored");
}

/// Printable characters only, at most 120.
std::string shown(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 120)) out += c >= ' ' && c <= '~' ? c : '?';
  return out;
}

}  // namespace

TiDialogue::TiDialogue(std::string_view config, std::string source)
    : rest_(config), source_(std::move(source)) {
  skip_to_command();
}

void TiDialogue::skip_to_command() {
  while (!rest_.empty()) {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    const std::string_view line = trimmed(rest_.substr(0, end));
    if (!line.empty() && line.front() != '%') return;
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++line_;
  }
}

std::optional<std::string_view> TiDialogue::next() {
  if (waiting_ || error_ || rest_.empty()) return std::nullopt;
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  command_ = trimmed(rest_.substr(0, end));
  command_line_ = line_++;
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  answer_.clear();
  waiting_ = true;
  return command_;
}

void TiDialogue::feed(std::string_view received) {
  if (!waiting_) return;  // a prompt before the first command, or text after the last
  answer_.append(received);
  if (answer_.find(kPrompt) != answer_.npos) {
    judge();
  } else if (answer_.size() > kLongestAnswer) {
    waiting_ = false;
    error_ = Error{ErrorCode::parse,
                   "'" + std::string(command_) + "': what answers is no sensor's " + "command port",
                   source_, command_line_};
  }
}

void TiDialogue::judge() {
  const std::string_view answer(answer_.data(), answer_.find(kPrompt));
  std::string_view fault;
  bool good = false;
  for_each_line(answer, [&](std::string_view line) {
    if (fault.empty() && reports_error(line)) fault = line;
    good = good || reports_success(line);
  });
  // The prompt of before this command: the answer follows.
  if (fault.empty() && !good && answer.find(command_) == answer.npos) {
    answer_.erase(0, answer.size() + kPrompt.size());
    return;
  }
  waiting_ = false;
  if (fault.empty() && good) {
    ++answered_;
    return skip_to_command();
  }
  const std::string why =
      fault.empty() ? "did not answer Done or Error" : "answered '" + shown(fault) + "'";
  error_ = Error{ErrorCode::invalid, "'" + shown(command_) + "': the sensor " + why, source_,
                 command_line_};
}

Error TiDialogue::no_answer() const {
  return Error{ErrorCode::io, "'" + shown(command_) + "': no answer from the sensor", source_,
               command_line_};
}

}  // namespace wayfare::decode
