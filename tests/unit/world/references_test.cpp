#include "world/references.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

#include "support/error_of.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string ErrorOf(const std::string& text) {
  return test::ErrorOf([&] { ParseReferences(text, "refs.toml"); });
}

TEST(References, ReadsEveryKey) {
  const ReferenceList list = ParseReferences(R"(sigma = 0.002
[[reference]]
id = 3
position = [1.5, -2]
[[reference]]
id = 4
family = 1
position = [0, 1, 0.25]
heading = 90
[[reference]]
id = 5
position = [2, 2, 1]
lies_flat = false
)",
                                             "refs.toml");
  EXPECT_EQ(list.sigma_m, 0.002);
  ASSERT_EQ(list.references.size(), 3u);
  EXPECT_EQ(list.references[0].id, 3u);
  EXPECT_EQ(list.references[0].position_in_world, Eigen::Vector3d(1.5, -2, 0));
  EXPECT_TRUE(list.references[0].lies_flat);
  EXPECT_FALSE(list.references[0].heading_rad.has_value());
  EXPECT_EQ(list.references[1].family, 1);
  EXPECT_EQ(list.references[1].position_in_world, Eigen::Vector3d(0, 1, 0.25));
  EXPECT_DOUBLE_EQ(list.references[1].heading_rad.value(), std::numbers::pi / 2);
  EXPECT_FALSE(list.references[2].lies_flat);
}

TEST(References, NamesFileLineAndKeyOfWhatIsWrong) {
  const std::string good = "[[reference]]\nid = 3\nposition = [1, 2]\n";
  EXPECT_EQ(ErrorOf(good), "no error");
  EXPECT_THAT(ErrorOf(""), AllOf(HasSubstr("reference"), HasSubstr("is missing")));
  EXPECT_THAT(ErrorOf("[[reference]]\nid = 3\n"), AllOf(HasSubstr("refs.toml"), HasSubstr("reference[0].position")));
  EXPECT_THAT(ErrorOf("[[reference]]\nid = 3\nposition = [1]\n"),
              AllOf(HasSubstr("refs.toml:3"), HasSubstr("position")));
  EXPECT_THAT(ErrorOf("[[reference]]\nid = \"3\"\nposition = [1, 2]\n"),
              AllOf(HasSubstr("refs.toml:2"), HasSubstr("id")));
  EXPECT_THAT(ErrorOf("sigma = 0\n" + good), AllOf(HasSubstr("refs.toml:1"), HasSubstr("sigma")));
  EXPECT_THAT(ErrorOf(good + "heading = 700\n"), AllOf(HasSubstr("refs.toml:4"), HasSubstr("heading = 700")));
  EXPECT_THAT(ErrorOf(good + "lies_flat = false\nheading = 7\n"),
              AllOf(HasSubstr("refs.toml:5"), HasSubstr("lie flat")));
  EXPECT_THAT(ErrorOf(good + "x = 7\n"), AllOf(HasSubstr("refs.toml:4"), HasSubstr("unknown key")));
}

TEST(References, RefusesOnesThatContradictEachOtherOnPaper) {
  const std::string good = "[[reference]]\nid = 3\nposition = [1, 2]\n";
  EXPECT_THAT(ErrorOf(good + "[[reference]]\nid = 3\nposition = [2, 2]\n"),
              AllOf(HasSubstr("refs.toml:5"), HasSubstr("stands twice")));
  EXPECT_THAT(ErrorOf(good + "[[reference]]\nid = 4\nposition = [1, 2]\n"),
              AllOf(HasSubstr("refs.toml:6"), HasSubstr("reference 3")));
  EXPECT_EQ(ErrorOf(good + "[[reference]]\nid = 3\nfamily = 1\nposition = [2, 2]\n"), "no error");
}

}  // namespace
}  // namespace chequer
