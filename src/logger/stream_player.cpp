#include <algorithm>
#include <thread>

#include <wayfare/logger/streams.hpp>

namespace wayfare::logger {

std::vector<TimedBytes> at_rate(decode::Bytes bytes, double bytes_per_s, std::size_t piece) {
  std::vector<TimedBytes> stream;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    const std::size_t n = std::min(piece, bytes.size() - at);
    stream.push_back(
        {from_seconds(static_cast<double>(at + n) / bytes_per_s), bytes.subspan(at, n)});
  }
  return stream;
}

Result<std::uint64_t> play(PseudoTerminal& terminal, const std::vector<TimedBytes>& stream,
                           double speed, const std::atomic<bool>& stop) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  std::uint64_t written = 0;
  for (const TimedBytes& piece : stream) {
    const auto due = begin + from_seconds(to_seconds(piece.at) / speed);
    while (!stop && Clock::now() < due)
      std::this_thread::sleep_until(std::min(due, Clock::now() + std::chrono::milliseconds(50)));
    decode::Bytes rest = piece.bytes;
    while (!rest.empty()) {
      if (stop) return written;
      const auto n = terminal.write(rest, std::chrono::milliseconds(50));
      if (!n) return n.error();
      written += *n;
      rest = rest.subspan(*n);
    }
  }
  return written;
}

}  // namespace wayfare::logger
