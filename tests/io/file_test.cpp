#include <wayfare/io/text_file.hpp>

#include <sys/stat.h>
#include <zlib.h>

#include <fstream>
#include <sstream>
#include <string>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;

std::string gzip(const std::string& bytes) {
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string sample() {
  std::string text;
  for (int i = 0; i < 20000; ++i) text += std::to_string(i * 7919 % 100003) + "\n";
  return text;
}

std::string slurp(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

TEST(File, GzipIsDecompressed) {
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder / "a.gz", gzip(sample())));
  ASSERT_TRUE(write_file(folder / "a", sample()));
  const Result<FileContent> packed = read_file(folder / "a.gz");
  const Result<FileContent> plain = read_file(folder / "a");
  ASSERT_TRUE(packed && plain);
  EXPECT_TRUE(packed->was_gzip);
  EXPECT_FALSE(plain->was_gzip);
  EXPECT_EQ(packed->bytes, sample());
  EXPECT_EQ(plain->bytes, sample());
  EXPECT_FALSE(packed->damage);
}

TEST(File, GzipMembersAreConcatenatedAndPaddingIsIgnored) {
  const Result<FileContent> content =
      decompress(gzip("one ") + gzip("two") + std::string(700, '\0'), "t");
  ASSERT_TRUE(content);
  EXPECT_EQ(content->bytes, "one two");
  EXPECT_FALSE(content->damage);
}

TEST(File, TruncatedGzipGivesTheIntactPartAndTheFault) {
  const std::string packed = gzip(sample());
  for (const std::size_t size : {packed.size() - 1, packed.size() / 2, std::size_t{2}}) {
    const Result<FileContent> content = decompress(packed.substr(0, size), "t.gz");
    ASSERT_TRUE(content);
    ASSERT_TRUE(content->damage);
    EXPECT_THAT(content->damage->to_string(), HasSubstr("cut off"));
    EXPECT_EQ(content->bytes, sample().substr(0, content->bytes.size()));
    if (size > 10) {
      EXPECT_GT(content->bytes.size(), sample().size() / 4);
    }
  }
}

TEST(File, DamagedGzipReportsThePosition) {
  std::string packed = gzip(sample());
  for (std::size_t i = 0; i < 50; ++i) packed[packed.size() / 2 + i] = '\x55';
  const Result<FileContent> content = decompress(packed, "t.gz");
  ASSERT_TRUE(content && content->damage);
  EXPECT_THAT(content->damage->to_string(), HasSubstr("damaged"));
  EXPECT_GT(content->damage->byte, 0U);
  const Result<FileContent> tail = decompress(gzip("good") + "rubbish", "t.gz");
  ASSERT_TRUE(tail && tail->damage);
  EXPECT_EQ(tail->bytes, "good");
  EXPECT_THAT(tail->damage->message, HasSubstr("not gzip"));
}

TEST(File, OversizedContentIsRejected) {
  std::string plain;
  plain.resize(50'000'000, 'a');
  const std::string bomb = gzip(plain);  // about 50 kB
  ASSERT_LT(bomb.size(), 100'000U);
  const Result<FileContent> content = decompress(bomb, "bomb.gz", {.max_bytes = 1'000'000});
  ASSERT_FALSE(content);
  EXPECT_THAT(content.error().to_string(),
              HasSubstr("bomb.gz: decompresses to more than the 1000000 bytes allowed"));
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder / "a", "12345"));
  EXPECT_TRUE(read_file(folder / "a", {.max_bytes = 5}));
  EXPECT_FALSE(read_file(folder / "a", {.max_bytes = 4}));
}

TEST(File, WritesAllOrNothing) {
  const testing::TemporaryFolder folder;
  const std::string path = folder / "out.txt";
  ASSERT_TRUE(write_file(path, "first"));
  const Result<void> again = write_file(path, "second");
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().to_string(), HasSubstr("not overwritten"));
  EXPECT_EQ(slurp(path), "first");
  ASSERT_TRUE(write_file(path, "third", {.existing = Existing::replace}));
  EXPECT_EQ(slurp(path), "third");
  EXPECT_FALSE(write_file(folder / "missing/out.txt", "x"));
  EXPECT_FALSE(write_file(folder.path().string(), "x", {.existing = Existing::replace}));
  // No temporary file remains.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(File, FollowsLinksAndKeepsDevices) {
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder / "real", "old"));
  std::filesystem::create_symlink(folder / "real", folder / "link");
  ASSERT_TRUE(write_file(folder / "link", "new", {.existing = Existing::replace}));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(slurp(folder / "real"), "new");
  ASSERT_TRUE(write_file("/dev/null", "gone"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(File, AFullDiskIsAnError) {
  const Result<void> done = write_file("/dev/full", "x");
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().to_string(), HasSubstr("No space left"));
}

}  // namespace
}  // namespace wayfare::io
