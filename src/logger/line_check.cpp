#include "logger/line_check.hpp"

#include <algorithm>
#include <utility>

namespace wayfare::logger {
namespace {

constexpr std::size_t kRecent = 1U << 16U;  // several frames of any device

bool is_text(std::uint8_t byte) {
  return (byte >= 0x20 && byte < 0x7F) || byte == '\r' || byte == '\n' || byte == '\t';
}

bool mostly_skipped(std::uint64_t skipped, std::uint64_t bytes) { return 2 * skipped > bytes; }

}  // namespace

std::string likely_cause(decode::Bytes bytes, const DeviceDescription& device) {
  constexpr std::size_t kLeast = 200;
  if (bytes.size() >= kLeast) {
    for (const std::string& kind : device_kinds()) {
      if (kind == device.kind || kind == "raw") continue;
      const auto other = make_decoder({"other", kind, device.baud, ""});
      if (!other) continue;
      (*other)->feed(bytes, LogTime(), [](const DecodedMessage&) {});
      if (!mostly_skipped((*other)->status().skipped_bytes, bytes.size()))
        return "they are of a device of kind " + kind + ": are the ports swapped?";
    }
  }
  const auto text = std::count_if(bytes.begin(), bytes.end(), is_text);
  if (static_cast<std::size_t>(text) * 20 >= bytes.size() * 19)
    return "they are text: is it a command port, or another device?";
  return "is the baud rate " + std::to_string(device.baud) + ", and is it a device of kind " +
         device.kind + "?";
}

void LineCheck::add(decode::Bytes bytes, const DecodingStatus& decoding, LogTime now) {
  if (recent_.size() > 2 * kRecent) recent_.erase(0, recent_.size() - kRecent);
  recent_.append(bytes.begin(), bytes.end());
  now_ = {now_.bytes + bytes.size(), decoding.skipped_bytes, decoding.messages};
  if (!window_begin_) window_begin_ = now;
  if (now - *window_begin_ < patience_ / 6) return;
  judge(window_, now_, now);
  window_ = now_;
  window_begin_ = now;
}

void LineCheck::judge(const Counts& window, const Counts& counts, LogTime now) {
  const std::uint64_t bytes = counts.bytes - window.bytes,
                      skipped = counts.skipped - window.skipped;
  if (!mostly_skipped(skipped, bytes) && counts.messages != window.messages) {
    bad_since_ = found_ = std::nullopt;
    good_ = counts;
    cause_.clear();
    return;
  }
  if (!bad_since_) bad_since_ = *window_begin_;
  if (now - *bad_since_ < patience_ || (found_ && now - *found_ < patience_)) return;
  found_ = now;
  const auto* data = reinterpret_cast<const std::uint8_t*>(recent_.data());
  cause_ = mostly_skipped(counts.skipped - good_.skipped, counts.bytes - good_.bytes)
               ? likely_cause({data, recent_.size()}, device_)
               : "they are messages of the device, but none is a measurement: does it measure?";
}

std::string LineCheck::warning() const {
  if (cause_.empty()) return {};
  return std::to_string(now_.bytes - good_.bytes) + " bytes without a measurement, " +
         std::to_string(now_.skipped - good_.skipped) + " of them in no message: " + cause_;
}

}  // namespace wayfare::logger
