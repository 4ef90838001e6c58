#include "print/sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "support/error_of.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

SheetOptions Options(std::size_t count) {
  SheetOptions options;
  for (std::size_t id = 0; id < count; ++id) options.ids.push_back(id);
  return options;
}

std::string ErrorOf(const SheetOptions& options) {
  return test::ErrorOf([&] { LayOutSheet(options); });
}

TEST(Sheet, PutsAsManyOnAPageAsFit) {
  const SheetLayout layout = LayOutSheet(Options(50));
  // 80 mm a tile with its margins, 84 mm with the caption, on 190 x 267 mm.
  EXPECT_EQ(layout.columns, 2);
  EXPECT_EQ(layout.rows, 3);
  ASSERT_EQ(layout.pages.size(), 9u);
  EXPECT_EQ(layout.pages[0].size(), 6u);
  EXPECT_EQ(layout.pages[8].size(), 2u);
  EXPECT_EQ(layout.pages[8][1].id, 49u);
  SheetOptions landscape = Options(50);
  landscape.paper = {0.297, 0.210};
  EXPECT_EQ(LayOutSheet(landscape).columns, 3);
}

TEST(Sheet, KeepsMarkersApartAndOnThePage) {
  for (const double side_m : {0.01, 0.033, 0.06, 0.1})
    for (const double margin : {0.0, 1.0, 2.5}) {
      SheetOptions options = Options(200);
      options.side_m = side_m;
      options.margin_cells = margin;
      const SheetLayout layout = LayOutSheet(options);
      const double whole = side_m + 2 * margin * options.CellM().x();
      for (const auto& page : layout.pages)
        for (std::size_t i = 0; i < page.size(); ++i) {
          const double left = page[i].x_m - margin * options.CellM().x(),
                       top = page[i].y_m - margin * options.CellM().y();
          EXPECT_GE(left, options.border_m - 1e-9);
          EXPECT_GE(top, options.border_m - 1e-9);
          EXPECT_LE(left + whole, options.paper.width_m - options.border_m + 1e-9);
          EXPECT_LE(top + whole + layout.caption_m, options.paper.height_m - options.border_m + 1e-9);
          for (std::size_t j = 0; j < i; ++j) {
            const double dx = std::abs(page[i].x_m - page[j].x_m), dy = std::abs(page[i].y_m - page[j].y_m);
            EXPECT_TRUE(dx >= whole + options.gap_m - 1e-9 || dy >= whole + layout.caption_m - 1e-9);
          }
        }
    }
}

TEST(Sheet, BothBarsAreAsLong) {
  const SheetLayout layout = LayOutSheet(Options(1));
  EXPECT_DOUBLE_EQ(layout.scale_bar_m, 0.1);
  EXPECT_DOUBLE_EQ(layout.upright_bar_m, 0.1);
  SheetOptions low = Options(1);
  low.paper = {0.297, 0.105};
  low.side_m = 0.04;
  EXPECT_EQ(LayOutSheet(low).upright_bar_m, 0);
}

TEST(Sheet, AMarkerThatJustFitsIsNotLost) {
  SheetOptions options = Options(1);
  options.margin_cells = 0;
  options.side_m = 0.19;
  EXPECT_EQ(LayOutSheet(options).columns, 1);
  options.side_m = 0.191;
  EXPECT_THAT(ErrorOf(options), HasSubstr("at most 190 mm"));
}

TEST(Sheet, SaysWhatIsWrong) {
  EXPECT_THAT(ErrorOf(Options(0)), HasSubstr("no ids"));
  SheetOptions options = Options(1);
  options.ids = {2048};
  EXPECT_THAT(ErrorOf(options), HasSubstr("id 2048 is beyond 2047"));
  options = Options(1);
  options.side_m = 0.001;
  EXPECT_THAT(ErrorOf(options), HasSubstr("side"));
  options = Options(1);
  options.gap_m = 0;
  EXPECT_THAT(ErrorOf(options), HasSubstr("gap"));
  options = Options(1);
  options.inks.blue = {0.9, 0.9, 1};
  EXPECT_THAT(ErrorOf(options), HasSubstr("black and blue"));
  options = Options(1);
  options.inks.yellow = {1, 1, 0.95};
  EXPECT_THAT(ErrorOf(options), HasSubstr("yellow"));
}

TEST(Sheet, KnowsPapersAndColours) {
  EXPECT_DOUBLE_EQ(ParsePaper("a3")->width_m, 0.297);
  EXPECT_DOUBLE_EQ(ParsePaper("Letter")->height_m, 0.2794);
  EXPECT_DOUBLE_EQ(ParsePaper("330x480mm")->height_m, 0.480);
  for (const char* wrong : {"", "A12", "x", "330", "330x", "0x10mm", "330x480m", "nanx100", "1e9x100"})
    EXPECT_FALSE(ParsePaper(wrong).has_value()) << wrong;
  EXPECT_EQ(ParseColour("#ff8000"), (PrintColour{1, 128 / 255.0, 0}));
  for (const char* wrong : {"", "ff8000", "#ff80", "#ff800g", "#ff80000"})
    EXPECT_FALSE(ParseColour(wrong).has_value()) << wrong;
  EXPECT_FALSE(NamedPrintInks("invisible").has_value());
  EXPECT_EQ(Caption(Options(1), 17), "17  6x6 secded  60 mm");
}

TEST(Sheet, DrawsCellsOfAWidthAndAHeight) {
  SheetOptions options = Options(1);
  const SheetLayout square = LayOutSheet(options);
  options.printed_m = {0.06, 0.0606};
  const SheetLayout taller = LayOutSheet(options);
  EXPECT_DOUBLE_EQ(taller.tile_width_m, square.tile_width_m);
  EXPECT_NEAR(taller.tile_height_m, square.tile_height_m + 8 * 0.0001, 1e-9) << "six cells and two of margin";
  EXPECT_THAT(Caption(options, 0), HasSubstr("60 x 60.6 mm"));
}

}  // namespace
}  // namespace chequer
