#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "publish/lcm_subscriber.h"
#include "tools/commands.h"
#include "tools/number_check.h"
#include "view/assets.h"
#include "view/server.h"

namespace chequer {
namespace {

ViewServer* running_server = nullptr;  ///< for the signal handler alone

void StopServing(int) { running_server->Stop(); }

void ServePage(ViewServerOptions options) {
  if (options.page.empty()) options.page = PageFolder(std::filesystem::read_symlink("/proc/self/exe"));
  std::signal(SIGPIPE, SIG_IGN);
  spdlog::set_default_logger(spdlog::stderr_logger_mt("view"));  // standard output is the page's address
  spdlog::set_pattern("chequer view: %v");
  ViewServer server(options);
  running_server = &server;
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, StopServing);
  std::printf("%s\n", server.url().c_str());
  std::fflush(stdout);
  server.Run();
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
  running_server = nullptr;
}

}  // namespace

void AddViewCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("view", "Serves a web page that shows what cameras and robots do");
  const auto options = std::make_shared<ViewServerOptions>();
  options->url = DefaultListenUrl();
  options->chart = "/usr/share/javascript/chart.js/chart.min.js";
  options->version = CHEQUER_VERSION;
  command->add_option("--url", options->url, "LCM URL; the default is the environment's LCM_DEFAULT_URL, else this")
      ->type_name("URL")
      ->capture_default_str();
  command->add_option("--log", options->log, "Replay this log of LCM instead; each page has a time line of its own")
      ->type_name("FILE");
  command->add_option("--address", options->address, "Listen at this address of the host")
      ->type_name("ADDRESS")
      ->capture_default_str();
  command->add_option("--port", options->port, "Listen at this port; 0: any that is free")
      ->check(IsWhole(0, 65535))
      ->capture_default_str();
  command
      ->add_option("--name", options->names,
                   "A name of this host under which browsers may ask, beside localhost and numbers; repeatable")
      ->type_name("NAME");
  command->add_option("--page", options->page, "Folder of the page's files; left out: where they were installed")
      ->type_name("FOLDER");
  command->add_option("--chart", options->chart, "The library of charts, which Debian's libjs-chart.js brings")
      ->type_name("FILE")
      ->capture_default_str();
  command->footer(
      "The page shows pictures with their markers, a map of the robots, how the services fare, and what would help. "
      "It\n"
      "changes nothing. It is for this host alone unless --address says otherwise; whoever can reach that address "
      "then\n"
      "can look, as there is no password. Pictures come from chequerd on request, where [view] of its configuration\n"
      "allows it.\n\n"
      "From another computer, without opening anything to the network:\n"
      "  ssh -L 8180:127.0.0.1:8180 HOST chequer view\n"
      "  then open http://127.0.0.1:8180/");
  command->callback([options] { ServePage(*options); });
}

}  // namespace chequer
