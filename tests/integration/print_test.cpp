// From a file to be printed back to the ids and sizes in it: what is drawn is rendered as a printer would and read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "support/process.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using test::RunResult;
using test::RunToEnd;
using test::TemporaryDirectory;
using ::testing::HasSubstr;

RunResult Print(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {CHEQUER, "print"});
  return RunToEnd(std::move(arguments));
}

/// All markers that are read in images, whichever.
std::vector<nlohmann::json> Detect(const std::vector<std::string>& images, const std::string& marker,
                                   const std::string& variant) {
  std::vector<std::string> arguments{CHEQUER, "detect", "--marker", marker, "--variant", variant, "--json"};
  arguments.insert(arguments.end(), images.begin(), images.end());
  const RunResult result = RunToEnd(arguments);
  EXPECT_EQ(result.status, 0) << result.output;
  std::vector<nlohmann::json> markers;
  std::istringstream lines(result.output);
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json image = nlohmann::json::parse(line);
    for (const auto& found : image["markers"]) markers.push_back(found);
  }
  return markers;
}

/// The pages of a PDF as images, in order.
std::vector<std::string> Pages(const std::filesystem::path& pdf) {
  const std::string stem = (pdf.parent_path() / pdf.stem()).string();
  const RunResult result = RunToEnd({"pdftoppm", "-r", "150", pdf.string(), stem + "_page"});
  EXPECT_EQ(result.status, 0) << result.output;
  std::vector<std::string> pages;
  for (const auto& entry : std::filesystem::directory_iterator(pdf.parent_path()))
    if (entry.path().filename().string().starts_with(pdf.stem().string() + "_page")) pages.push_back(entry.path());
  std::sort(pages.begin(), pages.end());
  return pages;
}

std::multiset<std::uint64_t> Ids(const std::vector<nlohmann::json>& markers) {
  std::multiset<std::uint64_t> ids;
  for (const auto& marker : markers) ids.insert(marker["id"].get<std::uint64_t>());
  return ids;
}

double Distance(const nlohmann::json& a, const nlohmann::json& b) {
  return std::hypot(a[0].get<double>() - b[0].get<double>(), a[1].get<double>() - b[1].get<double>());
}

/// Pixels from the first to the last inner corner, along and across.
void ExpectSides(const std::vector<nlohmann::json>& markers, int rows, int cols, double cell_px) {
  for (const auto& marker : markers) {
    const auto& corners = marker["corners"];
    const auto last = static_cast<std::size_t>((rows - 1) * (cols - 1) - 1),
               row_end = static_cast<std::size_t>(cols - 2);
    EXPECT_NEAR(Distance(corners[0], corners[row_end]) / ((cols - 2) * cell_px), 1, 0.002) << marker["id"];
    EXPECT_NEAR(Distance(corners[row_end], corners[last]) / ((rows - 2) * cell_px), 1, 0.002) << marker["id"];
  }
}

std::multiset<std::uint64_t> Range(std::uint64_t first, std::uint64_t last) {
  std::multiset<std::uint64_t> ids;
  for (std::uint64_t id = first; id <= last; ++id) ids.insert(id);
  return ids;
}

TEST(PrintCommand, PdfComesBackWithEveryIdAndSide) {
  const TemporaryDirectory directory;
  const std::filesystem::path pdf = directory.path() / "sheet.pdf";
  const RunResult printed =
      Print({"--variant", "secded", "--marker", "6x6", "--ids", "0-49", "--side", "60mm", "--out", pdf.string()});
  ASSERT_EQ(printed.status, 0) << printed.output;
  EXPECT_THAT(printed.output, HasSubstr("50 markers of 60 mm on 9 pages"));
  const auto markers = Detect(Pages(pdf), "6x6", "secded");
  EXPECT_EQ(Ids(markers), Range(0, 49));
  ExpectSides(markers, 6, 6, 10 / 25.4 * 150);
}

TEST(PrintCommand, OtherSizesPapersAndInksComeBackToo) {
  const TemporaryDirectory directory;
  for (const std::string inks : {"pure", "laser", "inkjet"}) {
    const std::filesystem::path pdf = directory.path() / (inks + ".pdf");
    ASSERT_EQ(Print({"--marker", "8x8", "--variant", "golay", "--ids", "100-107,4095", "--side", "4.8cm", "--paper",
                     "letter", "--landscape", "--margin", "0.5", "--inks", inks, "--out", pdf.string()})
                  .status,
              0);
    auto expected = Range(100, 107);
    expected.insert(4095);
    const auto markers = Detect(Pages(pdf), "8x8", "golay");
    EXPECT_EQ(Ids(markers), expected) << inks;
    ExpectSides(markers, 8, 8, 6 / 25.4 * 150);
  }
}

TEST(PrintCommand, BoardsThatAreNotSquareHaveTheSideTheyAreSaidToHave) {
  const TemporaryDirectory directory;
  const std::filesystem::path pdf = directory.path() / "sheet.pdf";
  ASSERT_EQ(
      Print({"--marker", "4x6", "--variant", "unconstrained", "--ids", "5-9", "--side", "0.06", "--out", pdf.string()})
          .status,
      0);
  const auto markers = Detect(Pages(pdf), "4x6", "unconstrained");
  EXPECT_EQ(Ids(markers), Range(5, 9));
  ExpectSides(markers, 4, 6, 10 / 25.4 * 150);
}

TEST(PrintCommand, PngPagesComeBack) {
  const TemporaryDirectory directory;
  ASSERT_EQ(
      Print({"--ids", "0-8", "--side", "60mm", "--dpi", "150", "--out", (directory.path() / "sheet.png").string()})
          .status,
      0);
  const auto markers = Detect(
      {(directory.path() / "sheet-1.png").string(), (directory.path() / "sheet-2.png").string()}, "6x6", "secded");
  EXPECT_EQ(Ids(markers), Range(0, 8));
  ExpectSides(markers, 6, 6, 10 / 25.4 * 150);
}

TEST(PrintCommand, WarnsWhereACameraWouldMissTheMarkers) {
  const TemporaryDirectory directory;
  const std::string out = (directory.path() / "sheet.svg").string();
  const std::vector<std::string> common{"--ids", "0", "--side", "60mm", "--focal", "1000", "--out", out};
  auto at = [&](const char* distance) {
    auto arguments = common;
    arguments.insert(arguments.end(), {"--distance", distance});
    return Print(arguments);
  };
  const RunResult far = at("3m"), near = at("2m");
  EXPECT_EQ(far.status, 0);
  EXPECT_THAT(far.output, HasSubstr("warning: cells are 3.33 px wide at 3 m"));
  EXPECT_THAT(far.output, HasSubstr("72 mm would do, or at most 2.50 m"));
  EXPECT_THAT(near.output, ::testing::Not(HasSubstr("warning")));
}

TEST(PrintCommand, SaysWhatIsWrong) {
  const TemporaryDirectory directory;
  const std::string out = (directory.path() / "sheet.pdf").string();
  const auto expect = [&](std::vector<std::string> arguments, int status, const char* what) {
    const RunResult result = Print(arguments);
    EXPECT_EQ(result.status, status) << result.output;
    EXPECT_THAT(result.output, HasSubstr(what));
  };
  expect({"--ids", "0", "--side", "60mm", "--out", "sheet.doc"}, 2, ".pdf, .svg or .png");
  expect({"--ids", "0", "--side", "60 bananas", "--out", out}, 2, "--side");
  expect({"--ids", "0-9999", "--side", "60mm", "--out", out}, 2, "2047");
  expect({"--ids", "0", "--side", "60mm", "--paper", "A99", "--out", out}, 2, "tabloid");
  expect({"--ids", "0", "--side", "60mm", "--inks", "sympathetic", "--out", out}, 2, "laser");
  expect({"--ids", "0", "--side", "60mm", "--blue", "#ffff00", "--out", out}, 2, "black and blue");
  expect({"--ids", "0", "--side", "60mm", "--focal", "900", "--out", out}, 2, "--distance");
  expect({"--ids", "0", "--side", "600mm", "--out", out}, 1, "do not fit on paper");
  expect({"--ids", "0", "--side", "60mm", "--out", "/proc/no/sheet.pdf"}, 1, "/proc/no");
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace chequer
