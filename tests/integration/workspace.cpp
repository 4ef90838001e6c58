#include "integration/workspace.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <variant>

#include "support/process.h"

namespace chequer::test {

void SetMulticastRoute(bool there) {
  Process ip({"ip", "route", there ? "add" : "del", "224.0.0.0/4", "dev", "lo"});
  if (ip.Wait() != 0) throw std::runtime_error("the multicast route cannot be changed: " + ip.output());
}

std::filesystem::path DemoRecording() { return std::filesystem::path(CHEQUER_TEST_DATA) / "data/demo_swarm"; }

std::string Workspace::Configure(const std::string& capture, const std::string& rest,
                                 const std::filesystem::path& recording) const {
  const std::filesystem::path file = folder_ / "chequerd.toml";
  std::ofstream(file) << "[camera]\nname = \"test\"\ncalibration = \"" << (DemoRecording() / "camera.toml").string()
                      << "\"\n[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\nside = 0.12\n[capture]\npath = \""
                      << recording.string() << "\"\n"
                      << capture << "\n"
                      << rest << "\n";
  return file.string();
}

std::uint64_t Received::Dropped(const std::string& reason) const {
  const std::vector<NamedCount>& drops = statuses.back().drops;
  return std::find_if(drops.begin(), drops.end(), [&](const NamedCount& drop) { return drop.name == reason; })->count;
}

Subscriber::Subscriber(const std::string& url)
    : subscriber_(url, {}, [this](const std::string&, ReceivedMessage&& message) {
        if (auto* poses = std::get_if<PosesMessage>(&message)) received_.poses.push_back(std::move(*poses));
        if (auto* status = std::get_if<StatusMessage>(&message)) received_.statuses.push_back(std::move(*status));
      }) {}

bool Subscriber::ReceiveUntil(const std::function<bool(const Received&)>& condition,
                              std::chrono::milliseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!condition(received_)) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    subscriber_.Wait(left);
  }
  return true;
}

}  // namespace chequer::test
