#pragma once

// A writer of MCAP driven by random calls, on a sink that may fail, beside a plain list of
// messages.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/io/mcap.hpp>

#include "io/mcap_samples.hpp"

namespace wayfare::tests {

using ::wayfare::testing::Remembered;

/// Fails from a given number of bytes, or of calls to `sync`, on.
class FailingSink final : public io::ByteSink {
 public:
  FailingSink(std::shared_ptr<std::string> bytes, std::size_t room, std::size_t syncs)
      : bytes_(std::move(bytes)), room_(room), syncs_(syncs) {}
  Result<void> write(std::string_view more) override {
    if (more.size() > room_ - bytes_->size()) return Error{ErrorCode::io, "no room left", "sink"};
    *bytes_ += more;
    return {};
  }
  Result<void> sync() override {
    if (syncs_ == 0) return Error{ErrorCode::io, "cannot be synced", "sink"};
    --syncs_;
    return {};
  }

 private:
  std::shared_ptr<std::string> bytes_;
  std::size_t room_, syncs_;
};

inline LogTime any_time(Rng& rng) {
  const auto small = static_cast<std::int64_t>(rng.below(1000));
  switch (rng.below(8)) {
    case 0:
      return LogTime::from_nanoseconds(0);
    case 1:
      return LogTime::from_nanoseconds(INT64_MAX - small);
    case 2:
      return LogTime::from_nanoseconds(1'000'000'000'000'000'000);
    default:
      return LogTime::from_nanoseconds(1'700'000'000'000'000'000 + small / 10);  // many are equal
  }
}

inline std::string any_data(Rng& rng) {
  std::string data(rng.below(10) == 0 ? rng.below(3000) : rng.below(30), '\0');
  for (char& c : data) c = static_cast<char>(rng.below(256));
  return data;
}

/// What the calls so far mean.
struct McapModel {
  std::vector<std::string> topics;
  std::size_t schemas = 0;
  std::vector<std::uint32_t> sequences;
  std::vector<Remembered> written;
  std::map<std::string, io::McapMetadata> metadata;
  std::optional<std::string> failed;
  bool closed = false;
};

/// A writer, driven by random calls.
class McapSession {
 public:
  McapSession(std::uint64_t seed, std::size_t room, std::size_t syncs)
      : rng_(seed),
        bytes_(std::make_shared<std::string>()),
        writer_(make_writer(room, syncs, std::size_t{64} << rng_.below(8))) {}

  void run(int calls) {
    for (int i = 0; i < calls && !::testing::Test::HasFailure(); ++i) call();
  }
  void close() {
    check("close", writer_.close());
    if (!model_.failed) model_.closed = true;
  }

  [[nodiscard]] const McapModel& model() const { return model_; }
  [[nodiscard]] const io::McapWriter& writer() const { return writer_; }
  [[nodiscard]] const std::string& bytes() const { return *bytes_; }
  [[nodiscard]] const std::string& calls() const { return calls_; }
  [[nodiscard]] Rng& rng() { return rng_; }

 private:
  io::McapWriter make_writer(std::size_t room, std::size_t syncs, std::size_t chunk_bytes) {
    auto writer = io::McapWriter::create(std::make_unique<FailingSink>(bytes_, room, syncs),
                                         {.chunk_bytes = chunk_bytes});
    return *std::move(writer);
  }

  /// Whether the call worked, which it must unless an error came before or comes from the sink.
  template <class T>
  bool check(const char* name, const Result<T>& result) {
    calls_ += std::string(name) + (result ? " " : "! ");
    if (model_.failed) {
      EXPECT_TRUE(!result && result.error().message == *model_.failed) << calls_;
    } else if (model_.closed) {
      EXPECT_FALSE(result) << calls_;
    } else if (!result) {
      EXPECT_EQ(result.error().source, "sink") << result.error().to_string() << '\n' << calls_;
      model_.failed = result.error().message;
    }
    return result.has_value();
  }
  /// An invalid call leaves everything as it is.
  template <class T>
  void refused(const char* name, const Result<T>& result) {
    calls_ += std::string(name) + "! ";
    EXPECT_FALSE(result) << calls_;
  }

  void call() {
    const std::uint64_t kind = rng_.below(60);
    if (kind < 2) {
      if (check("schema", writer_.add_schema("s", "e", any_data(rng_)))) ++model_.schemas;
    } else if (kind < 5) {
      add_channel();
    } else if (kind < 7) {
      check("flush", writer_.flush());
    } else if (kind == 7) {
      check("sync", writer_.sync());
    } else if (kind == 8) {
      const std::string name(1, static_cast<char>('a' + rng_.below(3)));
      const io::McapMetadata pairs{{"key", any_data(rng_)}, {"", ""}};
      if (check("metadata", writer_.add_metadata(name, pairs))) model_.metadata[name] = pairs;
    } else if (kind == 9) {
      const auto none = static_cast<std::uint16_t>(model_.topics.size() + rng_.below(3));
      refused("no_channel", writer_.write(none, LogTime(), LogTime(), "x"));
    } else if (kind == 10 && !model_.topics.empty()) {
      refused("early", writer_.write(0, LogTime::from_nanoseconds(-1), LogTime(), "x"));
      refused("early", writer_.write(0, LogTime(), LogTime::from_nanoseconds(INT64_MIN), "x"));
    } else if (kind == 11) {
      calls_ += "move ";
      io::McapWriter elsewhere(std::move(writer_));
      writer_ = std::move(elsewhere);
    } else if (kind == 12 && rng_.below(10) == 0) {
      close();
    } else if (!model_.topics.empty()) {
      write();
    }
  }

  void add_channel() {
    const auto schema = static_cast<std::uint16_t>(rng_.below(model_.schemas + 2));
    const std::string topic = "/" + std::to_string(rng_.below(4));  // topics may repeat
    if (schema > model_.schemas) return refused("channel", writer_.add_channel(topic, "e", schema));
    const auto id = writer_.add_channel(topic, "e", schema, {{"k", "v"}});
    if (!check("channel", id)) return;
    EXPECT_EQ(*id, model_.topics.size());
    model_.topics.push_back(topic);
    model_.sequences.push_back(0);
  }

  void write() {
    const auto channel = static_cast<std::uint16_t>(rng_.below(model_.topics.size()));
    const Remembered m{model_.topics[channel], any_data(rng_), model_.sequences[channel],
                       any_time(rng_), any_time(rng_)};
    if (!check("write", writer_.write(channel, m.log_time, m.publish_time, m.data))) return;
    model_.written.push_back(m);
    ++model_.sequences[channel];
  }

  Rng rng_;
  std::shared_ptr<std::string> bytes_;
  io::McapWriter writer_;
  McapModel model_;
  std::string calls_;
};

}  // namespace wayfare::tests
