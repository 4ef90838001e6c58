#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <filesystem>
#include <fstream>
#include <set>

#include "chequer/marker.h"
#include "support/error_of.h"
#include "support/seed.h"

namespace chequer {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// A file that lives as long as this object.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& content) {
    std::string pattern = (std::filesystem::temp_directory_path() / "chequer_table_XXXXXX").string();
    const int descriptor = mkstemp(pattern.data());
    if (descriptor < 0) throw std::runtime_error("cannot make a temporary file");
    close(descriptor);
    path_ = pattern;
    std::ofstream(path_, std::ios::binary) << content;
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() { std::filesystem::remove(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string LoadError(MarkerSize size, const std::filesystem::path& path) {
  return test::ErrorOf([&] { MarkerCode::LoadTable(size, path); });
}

std::string TableError(MarkerSize size, std::vector<std::uint64_t> kernels) {
  return test::ErrorOf([&] { MarkerCode::FromTable(size, std::move(kernels)); });
}

TEST(Table, MapsIdsToTheGivenKernels) {
  const MarkerCode code = MarkerCode::FromTable({4, 4}, {9, 0, 15});
  EXPECT_EQ(code.variant(), Variant::kTable);
  EXPECT_EQ(code.max_id(), 2u);
  EXPECT_EQ(code.guaranteed_radius(), 0);
  EXPECT_EQ(code.Encode(0), 9u);
  EXPECT_EQ(code.Encode(2), 15u);
  EXPECT_EQ(code.DecodeHard(0).value().id, 1u);
  EXPECT_EQ(code.DecodeHard(9).value().id, 0u);
  EXPECT_FALSE(code.DecodeHard(8).has_value());
  EXPECT_FALSE(code.DecodeHard(16).has_value());
}

TEST(Table, HoldsUpToSixtyFourBitsAndSixtyFiveThousandEntries) {
  EXPECT_EQ(MarkerCode::FromTable({10, 10}, {~std::uint64_t{0}}).Encode(0), ~std::uint64_t{0});
  std::vector<std::uint64_t> all(65536);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = 65535 - i;
  const MarkerCode code = MarkerCode::FromTable({6, 6}, all);
  EXPECT_EQ(code.DecodeHard(1).value().id, 65534u);
  EXPECT_EQ(code.min_distance(), 1);
  all.push_back(65536);
  EXPECT_THAT(TableError({7, 7}, all), AllOf(HasSubstr("65537"), HasSubstr("at most 65536")));
}

TEST(Table, MinimalDistanceIsThatOfTheClosestPair) {
  std::mt19937_64 random = test::SeededGenerator();
  for (const MarkerSize size : {MarkerSize{4, 4}, {5, 6}, {8, 8}, {10, 10}}) {
    const std::uint64_t all = ~std::uint64_t{0} >> (64 - KernelBits(size));
    for (const std::size_t count : {2u, 3u, 10u, 400u}) {
      std::set<std::uint64_t> kernels;
      while (kernels.size() < std::min<std::uint64_t>(count, all / 2)) kernels.insert(random() & all);
      int expected = 65;
      for (auto a = kernels.begin(); a != kernels.end(); ++a) {
        for (auto b = std::next(a); b != kernels.end(); ++b) expected = std::min(expected, std::popcount(*a ^ *b));
      }
      EXPECT_EQ(MarkerCode::FromTable(size, {kernels.begin(), kernels.end()}).min_distance(), expected);
    }
  }
  EXPECT_EQ(MarkerCode::FromTable({6, 6}, {0, 65535}).min_distance(), 16);
  EXPECT_EQ(MarkerCode::FromTable({6, 6}, {7}).min_distance(), 17);
}

TEST(Table, RefusesWhatIsNotATable) {
  EXPECT_THAT(TableError({6, 6}, {}), HasSubstr("at least one entry"));
  EXPECT_THAT(TableError({6, 6}, {1, 2, 65536}), AllOf(HasSubstr("entry 2"), HasSubstr("16 kernel cells")));
  EXPECT_THAT(TableError({6, 6}, {1, 5, 2, 5}), AllOf(HasSubstr("entry 1"), HasSubstr("entry 3"), HasSubstr("equal")));
  EXPECT_THAT(TableError({2, 2}, {0}), HasSubstr("at least 3"));
}

TEST(LoadTable, ReadsKernelsInOrderAndSkipsComments) {
  const TemporaryFile file("# my robots\n\n0110   # the first\r\n  1111\t\n#1010\n0000");
  const MarkerCode code = MarkerCode::LoadTable({4, 4}, file.path());
  EXPECT_EQ(code.max_id(), 2u);
  EXPECT_EQ(code.Encode(0), 0b0110u);
  EXPECT_EQ(code.Encode(1), 0b1111u);
  EXPECT_EQ(code.Encode(2), 0u);
  EXPECT_EQ(code.variant(), Variant::kTable);
}

TEST(LoadTable, NamesFileAndLineOfWhatIsWrong) {
  const TemporaryFile letters("0110\n01x0\n");
  EXPECT_THAT(LoadError({4, 4}, letters.path()),
              AllOf(HasSubstr(letters.path().string() + ":2"), HasSubstr("\"01x0\""), HasSubstr("4 digits 0 or 1")));
  const TemporaryFile longer("\n\n01100\n");
  EXPECT_THAT(LoadError({4, 4}, longer.path()), HasSubstr(longer.path().string() + ":3"));
  const TemporaryFile gap("01 10\n");
  EXPECT_THAT(LoadError({4, 4}, gap.path()), HasSubstr(":1"));
  const TemporaryFile twins("0110\n# between\n0001\n0110\n");
  EXPECT_THAT(LoadError({4, 4}, twins.path()),
              AllOf(HasSubstr(twins.path().string()), HasSubstr("line 1"), HasSubstr("line 4"), HasSubstr("equal")));
  const TemporaryFile empty("# nothing\n");
  EXPECT_THAT(LoadError({4, 4}, empty.path()), AllOf(HasSubstr(empty.path().string()), HasSubstr("at least one")));
  const TemporaryFile binary(std::string(100000, '\0'));
  EXPECT_LT(LoadError({4, 4}, binary.path()).size(), 400u) << "a message, not the file";
}

TEST(LoadTable, NamesAFileItCannotRead) {
  EXPECT_THAT(LoadError({4, 4}, "/nowhere/table.txt"),
              AllOf(HasSubstr("/nowhere/table.txt"), HasSubstr("No such file")));
  EXPECT_THAT(LoadError({4, 4}, std::filesystem::temp_directory_path()),
              HasSubstr(std::filesystem::temp_directory_path().string()));
}

TEST(LoadTable, RefusesMoreEntriesThanATableHolds) {
  std::string content;
  for (int i = 0; i <= 65536; ++i) {
    for (int bit = 24; bit >= 0; --bit) content += (i >> bit & 1) != 0 ? '1' : '0';
    content += '\n';
  }
  const TemporaryFile file(content);
  EXPECT_THAT(LoadError({7, 7}, file.path()), AllOf(HasSubstr(":65537"), HasSubstr("at most 65536")));
}

}  // namespace
}  // namespace chequer
