#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>

#include "manual/completion.h"
#include "manual/config_page.h"
#include "manual/program_page.h"
#include "manual/troff.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Troff, QuotesWhatWouldBeACommandOrAHyphen) {
  EXPECT_EQ(Troff("--url C:\\x"), "\\-\\-url C:\\ex");
  EXPECT_EQ(Troff(".SH not"), "\\&.SH not");
  EXPECT_EQ(Troff("'quoted'"), "\\&\\(aqquoted\\(aq");
}

TEST(Troff, KeepsExamplesAsTheyAre) {
  EXPECT_EQ(TroffParagraphs("One\ntwo.\n\nThree:\n  a  b\n  c\nFour."),
            "One\ntwo.\n.PP\nThree:\n.PP\n.RS 4\n.EX\na  b\nc\n.EE\n.RE\n.PP\nFour.\n");
}

/// A program with two commands.
class ManualTest : public ::testing::Test {
 protected:
  ManualTest() {
    app_.name("tool");
    app_.description("Does things.");
    CLI::App* listen = app_.add_subcommand("listen", "Listens long");
    listen->add_option("--url", url_, "Where to listen")->type_name("URL")->default_str("here");
    listen->add_flag("--json", json_, "As JSON");
    listen->footer("Example:\n  tool listen --json");
    CLI::App* show = app_.add_subcommand("show", "Shows files");
    show->add_option("--table", url_, "A table")->type_name("FILE")->required();
    show->add_option("files", files_, "What to show")->type_name("FILE")->required();
  }

  CLI::App app_;
  std::string url_;
  std::vector<std::string> files_;
  bool json_ = false;
};

TEST_F(ManualTest, APageHoldsWhatHelpSays) {
  const std::string page =
      ManualPage(app_, "1.2", {.section = 1, .summary = "does things", .more = ".SH MORE\n", .see_also = "other(8)"});
  for (const char* part : {".TH TOOL 1 \"\" \"chequer 1.2\"", "tool \\- does things", ".SS tool listen", "Listens long",
                           "\\fB\\-\\-url\\fR \\fIURL\\fR\nWhere to listen.\nDefault: here.\n", "As JSON",
                           ".EX\ntool listen \\-\\-json\n.EE", "Must be given.", ".SH MORE", "other(8)"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(page, HasSubstr("\\fBtool show\\fR \\fB\\-\\-table\\fR \\fIFILE\\fR"));
}

TEST_F(ManualTest, ACompletionOffersEachCommandsOptions) {
  const std::string text = BashCompletion(app_);
  EXPECT_THAT(text, AllOf(HasSubstr("'') offers='listen show --help"), HasSubstr("--table) mapfile"),
                          HasSubstr("--url) return"), HasSubstr("complete -o filenames -F _tool tool")));
  const std::string listen = text.substr(text.find("    listen)"), text.find("    show)") - text.find("    listen)"));
  EXPECT_THAT(listen, AllOf(HasSubstr("--json"), Not(HasSubstr("--table"))));
}

TEST(ConfigPage, TakesCommentsForTheTextOfWhatTheyStandAbove) {
  const std::string page = ConfigPage(
      "# All of it.\n\n[camera]\n# Its name.\nname = \"camera\"\n# Prose with a = sign.\n#file = \"a.toml\"\n\n"
      "# One for each kind.\n[[marker]]\n# Cells.\nsize = \"6x6\"\n",
      "1.2");
  EXPECT_THAT(page, HasSubstr(".SH DESCRIPTION\nAll of it.\n.SS [camera]\n"));
  EXPECT_THAT(page, HasSubstr(".TP\n\\fBname\\fR = \"camera\"\nIts name.\n"));
  EXPECT_THAT(
      page,
      HasSubstr(".TP\n\\fBfile\\fR = \"a.toml\"\n(left out by default; for example so.)\nProse with a = sign.\n"));
  EXPECT_THAT(page, HasSubstr(".SS [[marker]]\nOne for each kind.\n.TP\n\\fBsize\\fR"));
}

}  // namespace
}  // namespace chequer
