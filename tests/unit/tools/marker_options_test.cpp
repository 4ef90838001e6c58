#include "tools/marker_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string UsageError(const std::function<void()>& action) {
  try {
    action();
  } catch (const CLI::ValidationError& error) {
    return error.what();
  }
  return "no error";
}

std::string FamiliesError(const MarkerOptions& options, bool need_sides = false) {
  return UsageError([&] { ParseMarkerFamilies(options, need_sides); });
}

TEST(MarkerOptions, DefaultIsTheStandardMarker) {
  const auto families = ParseMarkerFamilies(MarkerOptions{}, false);
  ASSERT_EQ(families.size(), 1u);
  EXPECT_EQ(families[0].code.size(), (MarkerSize{6, 6}));
  EXPECT_EQ(families[0].code.variant(), Variant::kSecded);
  EXPECT_TRUE(families[0].roster.empty());
}

TEST(MarkerOptions, TakesSizeVariantAndSideInOneSeveralTimes) {
  MarkerOptions options;
  options.markers = {"6x6:color_constrained:0.12", "8x8:golay:0.2"};
  const auto families = ParseMarkerFamilies(options, true);
  ASSERT_EQ(families.size(), 2u);
  EXPECT_EQ(families[0].code.variant(), Variant::kColorConstrained);
  EXPECT_DOUBLE_EQ(families[0].side_m, 0.12);
  EXPECT_EQ(families[1].code.size(), (MarkerSize{8, 8}));
  EXPECT_DOUBLE_EQ(families[1].side_m, 0.2);
}

TEST(MarkerOptions, ParsesFromACommandLine) {
  MarkerOptions options;
  std::vector<std::string> files;
  CLI::App app;
  AddMarkerOptions(app, options);
  app.add_option("FILE", files);
  app.parse("--side 0.1 --marker 6x6 --marker 8x8:golay:0.2 --ids 3-4 a.png b.png");
  EXPECT_THAT(options.markers, ElementsAre("6x6", "8x8:golay:0.2"));
  EXPECT_THAT(files, ElementsAre("a.png", "b.png"));
  EXPECT_EQ(options.side_m, 0.1);
  EXPECT_EQ(options.ids, "3-4");
}

TEST(MarkerOptions, RefusesWhatIsNoSizeAndSaysWhatIs) {
  MarkerOptions options;
  options.markers = {"6by6"};
  EXPECT_THAT(FamiliesError(options), AllOf(HasSubstr("--marker"), HasSubstr("6by6"), HasSubstr("ROWSxCOLS")));
  options.markers = {"6x6:secded:0.12:9"};
  EXPECT_THAT(FamiliesError(options), HasSubstr("SIZE:VARIANT:SIDE"));
}

TEST(MarkerOptions, RefusesUnknownVariantAndListsTheKnown) {
  MarkerOptions options;
  options.variant = "sedced";
  EXPECT_THAT(FamiliesError(options), AllOf(HasSubstr("sedced"), HasSubstr("secded"), HasSubstr("reed_muller")));
  options.markers = {"6x6:nonsense:0.1"};
  EXPECT_THAT(FamiliesError(options), AllOf(HasSubstr("--marker"), HasSubstr("nonsense")));
}

TEST(MarkerOptions, RefusesAVariantThatTheSizeDoesNotHave) {
  MarkerOptions options;
  options.variant = "golay";
  EXPECT_THAT(FamiliesError(options), HasSubstr("golay"));
}

TEST(MarkerOptions, RefusesSidesThatAreNoLengths) {
  MarkerOptions options;
  for (const double side : {-0.1, 0.0}) {
    options.side_m = side;
    EXPECT_THAT(FamiliesError(options), AllOf(HasSubstr("--side"), HasSubstr("must be above 0")));
  }
  options.side_m.reset();
  for (const char* marker : {"6x6:secded:-0.1", "6x6:secded:wide", "6x6:secded:nan", "6x6:secded:"}) {
    options.markers = {marker};
    EXPECT_THAT(FamiliesError(options), HasSubstr("positive metres")) << marker;
  }
}

TEST(MarkerOptions, ReadsSidesWithUnits) {
  for (const char* side : {"120mm", "12cm", "0.12m", "0.12"}) {
    CLI::App app;
    MarkerOptions options;
    AddMarkerOptions(app, options);
    app.parse(std::string("--marker 6x6 --marker 8x8:golay:") + side + " --side " + side);
    const auto families = ParseMarkerFamilies(options, true);
    EXPECT_EQ(families[0].side_m, 0.12) << side;
    EXPECT_EQ(families[1].side_m, 0.12) << side;
  }
}

TEST(MarkerOptions, SuggestsTheVariantThatWasMeant) {
  MarkerOptions options;
  options.variant = "secdde";
  EXPECT_THAT(FamiliesError(options), HasSubstr("'secdde' is not a variant; did you mean 'secded'? Known are"));
}

TEST(MarkerOptions, AsksForTheSideOnlyWherePosesAreWanted) {
  EXPECT_EQ(FamiliesError(MarkerOptions{}, false), "no error");
  EXPECT_THAT(FamiliesError(MarkerOptions{}, true), AllOf(HasSubstr("--side"), HasSubstr("0.12")));
}

TEST(MarkerOptions, TableAndItsVariantNeedEachOther) {
  MarkerOptions options;
  options.variant = "table";
  EXPECT_THAT(FamiliesError(options), HasSubstr("needs --table FILE"));
  options.variant = "secded";
  options.table = "kernels.txt";
  EXPECT_THAT(FamiliesError(options), HasSubstr("only for the variant table"));
}

TEST(MarkerOptions, GivesEachFamilyTheIdsItHas) {
  MarkerOptions options;
  options.markers = {"6x6:reed_muller", "6x6:secded"};
  options.ids = "30-33";
  const auto families = ParseMarkerFamilies(options, false);
  EXPECT_THAT(families[0].roster, ElementsAre(30u, 31u));
  EXPECT_THAT(families[1].roster, ElementsAre(30u, 31u, 32u, 33u));
}

TEST(MarkerOptions, RefusesIdsThatNoFamilyHas) {
  MarkerOptions options;
  options.ids = "17,2048";
  EXPECT_THAT(FamiliesError(options), AllOf(HasSubstr("--ids"), HasSubstr("2048"), HasSubstr("0 to 2047")));
  options.markers = {"6x6:reed_muller", "6x6:secded"};
  options.ids = "100";
  EXPECT_THAT(FamiliesError(options), AllOf(HasSubstr("--ids"), HasSubstr("reed_muller"), HasSubstr("0 to 31")));
  options.ids = "31,2048";
  EXPECT_THAT(FamiliesError(options), AllOf(HasSubstr("--ids"), HasSubstr("2048")));
}

TEST(Roster, ReadsIdsAndRanges) {
  EXPECT_THAT(ParseRoster("0-3,77"), ElementsAre(0u, 1u, 2u, 3u, 77u));
  EXPECT_THAT(ParseRoster("18446744073709551615"), ElementsAre(UINT64_MAX));
  EXPECT_THAT(ParseRoster("18446744073709551614-18446744073709551615"), ElementsAre(UINT64_MAX - 1, UINT64_MAX));
}

TEST(Roster, RefusesWhatIsNoList) {
  for (const char* text : {"", ",", "1,", "a", "3-1", "-1", "1-", "1 2", "18446744073709551616"})
    EXPECT_THAT(UsageError([&] { ParseRoster(text); }), HasSubstr("0-49,77")) << "'" << text << "'";
}

TEST(Roster, RefusesARangeThatWouldFillTheMemory) {
  EXPECT_THAT(UsageError([&] { ParseRoster("0-18446744073709551615"); }), HasSubstr("more than 1000000"));
  EXPECT_THAT(UsageError([&] { ParseRoster("0-999999,5"); }), HasSubstr("more than 1000000"));
  EXPECT_EQ(ParseRoster("0-999999").size(), 1'000'000u);
}

TEST(MarkerOptions, ReadsWidthAndHeight) {
  for (const char* side : {"120.6x120mm", "120.6mmx120mm", "0.1206x0.12", "0.1206x12cm"}) {
    CLI::App app;
    MarkerOptions options;
    AddMarkerOptions(app, options);
    app.parse(std::string("--marker 6x6 --marker 6x6:secded:") + side + " --side " + side);
    if (std::string(side) == "0.1206x12cm") {
      EXPECT_THAT(FamiliesError(options), HasSubstr("nearly square")) << "the unit stands for both";
      continue;
    }
    for (const MarkerFamily& family : ParseMarkerFamilies(options, true))
      EXPECT_LT((family.CellM() - Eigen::Vector2d(0.0201, 0.02)).norm(), 1e-9) << side;
  }
}

}  // namespace
}  // namespace chequer
