// Random calls of McapWriter, on a sink that may fail, beside a plain list of messages; the file is
// then read whole, truncated and damaged, in both orders and by random queries.

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/io/mcap.hpp>

#include "abuse/abuse.hpp"
#include "io/mcap_samples.hpp"

namespace wayfare::io {
namespace {

using ::wayfare::testing::read_all;
using ::wayfare::testing::Remembered;

/// Fails from a given number of bytes, or of calls to `sync`, on.
class FailingSink final : public ByteSink {
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

LogTime any_time(Rng& rng) {
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

std::string any_data(Rng& rng) {
  std::string data(rng.below(10) == 0 ? rng.below(3000) : rng.below(30), '\0');
  for (char& c : data) c = static_cast<char>(rng.below(256));
  return data;
}

/// What the calls so far mean.
struct Model {
  std::vector<std::string> topics;
  std::size_t schemas = 0;
  std::vector<std::uint32_t> sequences;
  std::vector<Remembered> written;
  std::map<std::string, McapMetadata> metadata;
  std::optional<std::string> failed;
  bool closed = false;
};

/// A writer, driven by random calls.
class Session {
 public:
  Session(std::uint64_t seed, std::size_t room, std::size_t syncs)
      : rng_(seed),
        bytes_(std::make_shared<std::string>()),
        writer_(make_writer(room, syncs, 64 << rng_.below(8))) {}

  void run(int calls) {
    for (int i = 0; i < calls && !::testing::Test::HasFailure(); ++i) call();
  }
  void close() {
    check("close", writer_.close());
    if (!model_.failed) model_.closed = true;
  }

  [[nodiscard]] const Model& model() const { return model_; }
  [[nodiscard]] const McapWriter& writer() const { return writer_; }
  [[nodiscard]] const std::string& bytes() const { return *bytes_; }
  [[nodiscard]] const std::string& calls() const { return calls_; }
  [[nodiscard]] Rng& rng() { return rng_; }

 private:
  McapWriter make_writer(std::size_t room, std::size_t syncs, std::size_t chunk_bytes) {
    auto writer = McapWriter::create(std::make_unique<FailingSink>(bytes_, room, syncs),
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
      const McapMetadata pairs{{"key", any_data(rng_)}, {"", ""}};
      if (check("metadata", writer_.add_metadata(name, pairs))) model_.metadata[name] = pairs;
    } else if (kind == 9) {
      const auto none = static_cast<std::uint16_t>(model_.topics.size() + rng_.below(3));
      refused("no_channel", writer_.write(none, LogTime(), LogTime(), "x"));
    } else if (kind == 10 && !model_.topics.empty()) {
      refused("early", writer_.write(0, LogTime::from_nanoseconds(-1), LogTime(), "x"));
      refused("early", writer_.write(0, LogTime(), LogTime::from_nanoseconds(INT64_MIN), "x"));
    } else if (kind == 11) {
      calls_ += "move ";
      McapWriter elsewhere(std::move(writer_));
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
  McapWriter writer_;
  Model model_;
  std::string calls_;
};

std::vector<Remembered> sorted(std::vector<Remembered> messages) {
  std::stable_sort(messages.begin(), messages.end(), [](const Remembered& a, const Remembered& b) {
    return a.log_time < b.log_time;
  });
  return messages;
}

std::vector<Remembered> chosen(const McapQuery& query, std::vector<Remembered> all) {
  std::erase_if(all, [&](const Remembered& m) {
    return m.log_time < query.from || m.log_time > query.until ||
           (!query.topics.empty() && !query.topics.contains(m.topic));
  });
  return query.order == McapOrder::log_time ? sorted(std::move(all)) : all;
}

/// Both orders, all of it and by random queries, also stopped early.
void expect_messages(const McapReader& reader, const std::vector<Remembered>& expected, Rng& rng) {
  for (int k = 0; k < 6; ++k) {
    McapQuery query;
    query.order = k % 2 == 0 ? McapOrder::file : McapOrder::log_time;
    if (k >= 2) {
      while (rng.below(2) == 0) query.topics.insert("/" + std::to_string(rng.below(5)));
      if (rng.below(2) == 0) query.from = any_time(rng);
      if (rng.below(2) == 0) query.until = any_time(rng);
    }
    std::vector<Remembered> wanted = chosen(query, expected);
    ASSERT_EQ(read_all(reader, query), wanted) << "query " << k;
    if (wanted.empty()) continue;
    std::size_t left = 1 + rng.below(wanted.size());
    std::vector<std::string> first;
    static_cast<void>(reader.read(query, [&](const McapMessage& m) {
      first.emplace_back(m.data);
      return --left > 0;
    }));
    for (std::size_t i = 0; i < first.size(); ++i) ASSERT_EQ(first[i], wanted[i].data);
  }
}

void expect_contents(const McapContents& contents, const Model& model) {
  const McapStatistics& s = contents.statistics;
  ASSERT_EQ(s.messages, model.written.size());
  std::uint64_t sum = 0;
  for (const auto& [channel, count] : s.messages_of) sum += count;
  EXPECT_EQ(sum, model.written.size());
  if (!model.written.empty()) {
    const auto all = sorted(model.written);
    EXPECT_EQ(s.first, all.front().log_time);
    EXPECT_EQ(s.last, all.back().log_time);
  }
  EXPECT_EQ(contents.metadata, model.metadata);
  ASSERT_EQ(contents.channels.size(), model.topics.size());
  for (std::size_t i = 0; i < model.topics.size(); ++i)
    EXPECT_EQ(contents.channels[i].topic, model.topics[i]);
  EXPECT_EQ(contents.schemas.size(), model.schemas);
}

TEST(McapSequences, AreReadAsTheListOfMessages) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Session session(seed, SIZE_MAX, SIZE_MAX);
    session.run(static_cast<int>(session.rng().below(150)));
    if (!session.model().closed) session.close();
    SCOPED_TRACE(session.calls());
    ASSERT_FALSE(HasFailure());
    const auto reader = McapReader::parse(session.bytes(), "memory");
    ASSERT_TRUE(reader);
    EXPECT_TRUE(reader->contents().indexed);
    EXPECT_TRUE(reader->contents().problems.empty());
    expect_contents(reader->contents(), session.model());
    expect_messages(*reader, session.model().written, session.rng());
    // Without the summary it is the same.
    const auto front = McapReader::parse(
        session.bytes().substr(0, session.bytes().size() - 1 - session.rng().below(8)), "memory");
    ASSERT_TRUE(front);
    EXPECT_FALSE(front->contents().indexed);
    expect_contents(front->contents(), session.model());
    expect_messages(*front, session.model().written, session.rng());
    ASSERT_FALSE(HasFailure());
  }
}

TEST(McapSequences, AFailingSinkKeepsWhatWasFlushed) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng = Rng(seed).stream(9);
    const bool full = rng.below(2) == 0;
    Session session(seed, full ? 100 + rng.below(5000) : SIZE_MAX, full ? SIZE_MAX : rng.below(3));
    session.run(120);
    session.close();
    if (session.model().failed) session.close();  // the same error again
    SCOPED_TRACE(session.calls());
    ASSERT_FALSE(HasFailure());
    const auto reader = McapReader::parse(session.bytes(), "memory");
    ASSERT_TRUE(reader);
    std::vector<Remembered> flushed = session.model().written;
    const std::uint64_t count = session.writer().statistics().messages;
    ASSERT_LE(count, flushed.size());
    flushed.resize(count);
    expect_messages(*reader, flushed, session.rng());
    EXPECT_EQ(session.writer().bytes_written(), session.bytes().size());
    ASSERT_FALSE(HasFailure());
  }
}

/// Whether `part` is `whole` with some messages left out, apart from `foreign` others.
bool is_part(const std::vector<Remembered>& part, const std::vector<Remembered>& whole,
             std::size_t foreign = 0) {
  std::size_t next = 0;
  for (const Remembered& m : part) {
    std::size_t at = next;
    while (at < whole.size() && !(whole[at] == m)) ++at;
    if (at == whole.size()) {
      if (foreign-- == 0) return false;
    } else {
      next = at + 1;
    }
  }
  return true;
}

TEST(McapSequences, TruncatedAnywhereAreAPrefix) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Session session(seed, SIZE_MAX, SIZE_MAX);
    session.run(80);
    if (!session.model().closed) session.close();
    const std::vector<Remembered>& written = session.model().written;
    std::size_t before = 0;
    std::vector<std::size_t> cuts;
    for (int k = 0; k < 12; ++k) cuts.push_back(session.rng().below(session.bytes().size()));
    std::sort(cuts.begin(), cuts.end());
    for (const std::size_t cut : cuts) {
      SCOPED_TRACE("cut " + std::to_string(cut));
      const auto reader = McapReader::parse(session.bytes().substr(0, cut), "memory");
      ASSERT_EQ(reader.has_value(), cut >= 8);
      if (!reader) continue;
      const auto read = read_all(*reader);
      ASSERT_LE(before, read.size()) << "a longer file has more messages";
      ASSERT_TRUE(std::equal(read.begin(), read.end(), written.begin()));
      EXPECT_FALSE(reader->contents().problems.empty());
      expect_messages(*reader, read, session.rng());
      before = read.size();
    }
    ASSERT_FALSE(HasFailure());
  }
}

TEST(McapSequences, AFlippedBitMakesNoOtherMessage) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Session session(seed, SIZE_MAX, SIZE_MAX);
    session.run(60);
    if (!session.model().closed) session.close();
    const std::vector<Remembered>& written = session.model().written;
    for (int k = 0; k < 12; ++k) {
      std::string bytes = session.bytes();
      const std::size_t at = session.rng().below(bytes.size());
      const std::uint64_t bit = session.rng().below(8);
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << bit));
      SCOPED_TRACE("bit " + std::to_string(bit) + " of byte " + std::to_string(at));
      const auto reader = McapReader::parse(bytes, "memory");
      ASSERT_EQ(reader.has_value(), at >= 8);
      if (!reader) continue;
      // Outside of chunks the format has no checksum, unless the summary tells what there is.
      const std::size_t foreign = reader->contents().indexed ? 0 : 1;
      ASSERT_TRUE(is_part(read_all(*reader), written, foreign));
      ASSERT_TRUE(
          is_part(read_all(*reader, {.order = McapOrder::log_time}), sorted(written), foreign));
    }
  }
}

TEST(McapSequences, TwoWritersInTwoThreadsAreIndependent) {
  const auto both = tests::in_two_threads([](int) {
    Session session(3, SIZE_MAX, SIZE_MAX);
    session.run(300);
    if (!session.model().closed) session.close();
    const auto reader = McapReader::parse(session.bytes(), "memory");
    return std::pair(session.bytes(), reader ? read_all(*reader) : std::vector<Remembered>());
  });
  EXPECT_EQ(both[0].first, both[1].first);
  EXPECT_EQ(both[0].second, both[1].second);
  // One reader is shared: reading is const.
  const auto reader = McapReader::parse(both[0].first, "memory");
  ASSERT_TRUE(reader);
  const auto read = tests::in_two_threads([&](int i) {
    return read_all(*reader, {.order = i == 0 ? McapOrder::file : McapOrder::log_time});
  });
  EXPECT_EQ(sorted(read[0]), read[1]);
}

}  // namespace
}  // namespace wayfare::io
