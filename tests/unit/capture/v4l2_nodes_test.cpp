#include "capture/v4l2_nodes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "support/temporary_directory.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

void Write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text << "\n";
}

/// A host with a webcam of two nodes, as the kernel and udev show it.
class V4l2NodesTest : public ::testing::Test {
 protected:
  V4l2NodesTest() {
    const fs::path usb = folder_ / "sys/devices/pci0000:00/usb1/1-2";
    Write(usb / "idVendor", "046d");
    Write(usb / "serial", "ABC123");
    AddNode(2, usb / "1-2:1.0", "Webcam", 0);
    AddNode(10, usb / "1-2:1.0", "Webcam", 1);
    fs::create_directories(folder_ / "dev/v4l/by-id");
    fs::create_symlink(folder_ / "dev/video2", folder_ / "dev/v4l/by-id/usb-Webcam-index0");
    fs::create_symlink(folder_ / "dev/video7", folder_ / "dev/v4l/by-id/broken");
  }

  void AddNode(int number, const fs::path& device, const std::string& name, int index) {
    const std::string node = "video" + std::to_string(number);
    const fs::path entry = folder_ / "sys/class/video4linux" / node;
    Write(entry / "name", name);
    Write(entry / "index", std::to_string(index));
    fs::create_directories(device);
    fs::create_directory_symlink(device, entry / "device");
    Write(folder_ / "dev" / node, "");
  }

  V4l2Roots Roots() const { return {folder_ / "sys", folder_ / "dev"}; }

  test::TemporaryDirectory folder_;
};

TEST_F(V4l2NodesTest, AreReadWithWhatTellsThemApart) {
  const std::vector<V4l2Node> nodes = ListV4l2Nodes(Roots());
  ASSERT_EQ(nodes.size(), 2u);
  EXPECT_EQ(nodes[0].path, (folder_ / "dev/video2").string());
  EXPECT_EQ(nodes[0].name, "Webcam");
  EXPECT_EQ(nodes[0].serial, "ABC123");
  EXPECT_EQ(nodes[0].port, "devices/pci0000:00/usb1/1-2/1-2:1.0");
  EXPECT_THAT(nodes[0].links, ElementsAre((folder_ / "dev/v4l/by-id/usb-Webcam-index0").string()));
  EXPECT_EQ(nodes[1].index, 1);
  EXPECT_THAT(nodes[1].links, IsEmpty());
}

TEST(ListV4l2Nodes, IsEmptyWithoutV4l2) {
  const test::TemporaryDirectory folder;
  EXPECT_THAT(ListV4l2Nodes({folder / "sys", folder / "dev"}), IsEmpty());
}

V4l2Node Node(const std::string& path, const std::string& name, const std::string& serial, const std::string& port) {
  return {path, name, serial, port, 0, {}};
}

const V4l2Node kLeftNode = Node("/dev/video0", "Webcam", "L", "usb1");
const V4l2Node kRightNode = Node("/dev/video2", "Webcam", "R", "usb2");
const V4l2Node kOtherNode = Node("/dev/video4", "Capture card", "", "pci3");
const std::vector<V4l2Node> kAllNodes{kLeftNode, kRightNode, kOtherNode};

V4l2Found FindNode(const std::vector<V4l2Node>& nodes, const std::string& device,
                   const std::optional<V4l2Node>& known = std::nullopt) {
  return FindV4l2Node(nodes, device, "capture.device", known);
}

TEST(FindV4l2Node, ByPathNameAndSerialNumber) {
  EXPECT_EQ(FindNode(kAllNodes, "/dev/video2").node, kRightNode);
  EXPECT_EQ(FindNode(kAllNodes, "R").node, kRightNode);
  EXPECT_EQ(FindNode(kAllNodes, "Capture card").node, kOtherNode);
  EXPECT_EQ(FindNode({kOtherNode}, "").node, kOtherNode);
}

TEST(FindV4l2Node, SaysWhatIsThere) {
  EXPECT_EQ(FindNode(kAllNodes, "/dev/video9").problem,
            "capture.device: no camera '/dev/video9' is there; there are /dev/video0 (Webcam, serial L), /dev/video2 "
            "(Webcam, serial R), /dev/video4 (Capture card)");
  EXPECT_EQ(FindNode({}, "").problem, "capture.device: no camera is there; no V4L2 device is there");
}

TEST(FindV4l2Node, RefusesWhatIsNotEnough) {
  for (const char* device : {"Webcam", ""}) {
    try {
      FindNode(kAllNodes, device);
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("several cameras are meant: /dev/video0 (Webcam, serial L), /dev/video2"));
    }
  }
}

TEST(FindV4l2Node, FindsTheSameCameraUnderAnotherNode) {
  V4l2Node moved = kRightNode;
  moved.path = "/dev/video5";
  moved.port = "usb9";
  EXPECT_EQ(FindNode({kLeftNode, moved}, "/dev/video2", kRightNode).node, moved);
}

TEST(FindV4l2Node, NeverTakesAnotherCameraForIt) {
  V4l2Node other = kLeftNode;
  other.path = "/dev/video2";  // it has the number now
  EXPECT_EQ(FindNode({other}, "/dev/video2", kRightNode).node, std::nullopt);
  EXPECT_THAT(FindNode({other}, "/dev/video2", kRightNode).problem, HasSubstr("is not there any more"));
}

TEST(FindV4l2Node, KnowsCamerasWithoutSerialNumberByTheirPlace) {
  V4l2Node again = kOtherNode;
  again.path = "/dev/video1";
  EXPECT_EQ(FindNode({again}, "/dev/video4", kOtherNode).node, again);
  again.port = "pci4";
  EXPECT_EQ(FindNode({again}, "/dev/video4", kOtherNode).node, std::nullopt);
}

TEST(FindV4l2Node, TellsTwinsWithOneSerialNumberApartByTheirPlace) {
  V4l2Node first = Node("/dev/video0", "Webcam", "0001", "usb1"),
           second = Node("/dev/video2", "Webcam", "0001", "usb2");
  EXPECT_EQ(FindNode({first, second}, "/dev/video2", second).node, second);
}

TEST(FindV4l2Node, LeavesStableLinksToUdev) {
  V4l2Node spare = Node("/dev/video0", "Webcam", "S", "usb2");
  spare.links = {"/dev/v4l/by-path/usb2"};
  EXPECT_EQ(FindNode({spare}, "/dev/v4l/by-path/usb2", kRightNode).node, spare);
}

}  // namespace
}  // namespace chequer
