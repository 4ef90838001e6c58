#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "manual/completion.h"
#include "manual/config_page.h"
#include "manual/program_page.h"
#include "manual/troff.h"
#include "support/process.h"

namespace chequer {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Troff, QuotesWhatWouldBeACommandOrAHyphen) {
  EXPECT_EQ(Troff("--url C:\\x"), "\\-\\-url C:\\ex");
  EXPECT_EQ(Troff(".SH not"), "\\&.SH not");
  EXPECT_EQ(Troff("'quoted'"), "\\&\\(aqquoted\\(aq");
}

TEST(Troff, KeepsExamplesAsTheyAre) {
  EXPECT_EQ(TroffParagraphs("One\ntwo.\n\nThree:\n  a  b\n  c\nFour."),
            "One\ntwo.\n.PP\nThree:\n.PP\n.RS 4\n.EX\na  b\nc\n.EE\n.RE\n.PP\nFour.\n");
}

/// A program with three commands, one of which has commands of its own.
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
    CLI::App* set = app_.add_subcommand("set", "Sets sizes");
    set->add_subcommand("width", "Sets the width")->add_flag("--millimetres", json_, "Instead of inches");
    set->add_subcommand("height", "Sets the height");
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

/// What bash offers for a command line, whose last word is to be completed; sorted.
std::vector<std::string> Complete(const std::string& completion, std::vector<std::string> words) {
  const std::string ask =
      completion +
      "COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); \"_$1\"; printf '%s\\n' \"${COMPREPLY[@]}\" | LC_ALL=C sort\n";
  words.insert(words.begin(), {"bash", "-c", ask, "bash"});
  test::Process bash(words);
  EXPECT_EQ(bash.Wait(), 0) << bash.output();
  std::istringstream lines(bash.output());
  std::vector<std::string> offers;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) offers.push_back(line);
  return offers;
}

TEST_F(ManualTest, BashCompletesCommandsAndTheirOptions) {
  const std::string completion = BashCompletion(app_);
  EXPECT_THAT(completion, HasSubstr("complete -o filenames -F _tool tool"));
  EXPECT_THAT(Complete(completion, {"tool", ""}), ElementsAre("--help", "listen", "set", "show"));
  EXPECT_THAT(Complete(completion, {"tool", "s"}), ElementsAre("set", "show"));
  EXPECT_THAT(Complete(completion, {"tool", "listen", "--"}), ElementsAre("--help", "--json", "--url"));
  EXPECT_THAT(Complete(completion, {"tool", "listen", "--url", ""}), IsEmpty()) << "nobody knows";
  EXPECT_THAT(Complete(completion, {"tool", "listen", ""}), ElementsAre("--help", "--json", "--url"));
}

TEST_F(ManualTest, BashCompletesCommandsOfCommands) {
  const std::string completion = BashCompletion(app_);
  EXPECT_THAT(Complete(completion, {"tool", "set", "wi"}), ElementsAre("width"));
  EXPECT_THAT(Complete(completion, {"tool", "set", ""}), ElementsAre("--help", "height", "width"));
  EXPECT_THAT(Complete(completion, {"tool", "set", "width", "--"}), ElementsAre("--help", "--millimetres"));
  EXPECT_THAT(Complete(completion, {"tool", "set", "height", "--m"}), IsEmpty()) << "that is the other's";
  EXPECT_THAT(Complete(completion, {"tool", "listen", "set", "--u"}), ElementsAre("--url")) << "a word, not a command";
}

TEST_F(ManualTest, BashCompletesFilesWhereTheyAreWanted) {
  const std::string completion = BashCompletion(app_);
  const std::string here = std::string(CHEQUER_TEST_DATA) + "/unit/manual/manual_t";
  const auto file = ElementsAre(here + "est.cpp");
  EXPECT_THAT(Complete(completion, {"tool", "show", here}), file);
  EXPECT_THAT(Complete(completion, {"tool", "show", "--table", here}), file);
  EXPECT_THAT(Complete(completion, {"tool", "listen", here}), IsEmpty());
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
