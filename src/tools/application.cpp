#include "tools/application.h"

#include "tools/commands.h"

namespace chequer {

void DescribeTool(CLI::App& app) {
  app.name("chequer");
  app.description(
      "Prints, finds, explains and renders colour-checkerboard markers, calibrates cameras, and listens to poses.");
  app.set_version_flag("--version", std::string("chequer ") + CHEQUER_VERSION);
  app.require_subcommand(1);
  app.footer("chequer COMMAND --help says more, with an example.");
  AddCalibrateCommand(app);
  AddCamerasCommand(app);
  AddConvertCommand(app);
  AddDetectCommand(app);
  AddEvaluateCommand(app);
  AddExplainCommand(app);
  AddListenCommand(app);
  AddPlanCommand(app);
  AddPrintCommand(app);
  AddRecordCommand(app);
  AddRenderCommand(app);
  AddSnapshotCommand(app);
  AddStartCommand(app);
  AddStatusCommand(app);
  AddViewCommand(app);
}

}  // namespace chequer
