/// The program: what the command line asks for, and the exit code that answers it.
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "scenes/bundled.h"
#include "scenes/experiments/experiment.h"
#include "scenes/json_text.h"
#include "scenes/reference.h"
#include "scenes/run.h"
#include "scenes/scene_file.h"
#include "scenes/version.h"

namespace {

using namespace wick;
using namespace wick::scenes;

int code(ExitCode value) {
  return static_cast<int>(value);
}

struct CommandLine {
  RunOptions options;
  std::string scene;
  std::string pointer;
  ExperimentOptions experiment;
  int frames = 0;
  int requeue_code = static_cast<int>(ExitCode::checkpointed);
  bool markdown = false;
};

/// A variable of a script that is not set must not mean the default.
const CLI::Validator not_empty([](const std::string& text) { return std::string(text.empty() ? "is empty" : ""); },
                               "");

/// A whole number from `least` to `most`, shown as N.
void add_number(CLI::App& command, const char* option, int& value, int least, int most, const std::string& what) {
  command.add_option(option, value, what)->type_name("N")->check(CLI::Range(least, most).description(""));
}

void add_scene_options(CLI::App& command, CommandLine& line) {
  command.add_option("scene", line.scene, "scene file, or the name of a bundled scene (see wick list)")
      ->type_name("")
      ->required()
      ->check(not_empty);
  command.add_option("--out", line.options.out, "output folder [out/<scene name>]")
      ->type_name("DIR")
      ->check(not_empty);
  add_number(command, "--frames", line.frames, 1, 10000000,
             "frames to compute, counted from the first (the initial state)");
  command.add_option("--set", line.options.set, "change one parameter, or remove it (null); may be given again")
      ->type_name("/POINTER=VALUE")
      ->allow_extra_args(false);
  add_number(command, "--threads", line.options.threads, 1, 1024, "threads to use [all]");
  command.add_flag("--quiet", line.options.quiet, "say nothing but errors");
}

void add_commands(CLI::App& app, CommandLine& line) {
  app.set_version_flag("--version", std::string("wick ") + version, "print the version");
  app.set_help_flag("-h,--help", "print this help");
  app.require_subcommand(1);
  CLI::App* run = app.add_subcommand("run", "compute a scene; goes on where an earlier run of it stopped");
  add_scene_options(*run, line);
  run->add_flag("--restart", line.options.restart,
                "remove what an earlier run left in the output folder, and begin anew");
  add_number(*run, "--requeue-code", line.requeue_code, 1, 255, "exit code after a stop on request [75]");
  add_scene_options(*app.add_subcommand("check", "check a scene without computing it"), line);
  app.add_subcommand("list", "list the bundled scenes");
  CLI::App* explain = app.add_subcommand("explain", "list the parameters of a scene");
  explain->add_option("pointer", line.pointer, "only what is at or below /this/pointer")->type_name("");
  explain->add_flag("--markdown", line.markdown, "the whole reference as a page");
  app.add_subcommand("schema", "print the JSON Schema of scene files");
  CLI::App* experiment = app.add_subcommand("experiment", "measure a figure of the paper");
  experiment->add_option("names", line.experiment.names, "experiments, or all, or list [list]")->type_name("");
  experiment->add_flag("--quick", line.experiment.quick, "fewer seeds: a look, not a result");
  experiment->add_option("--out", line.experiment.out, "folder of tables and pictures [out/experiments]")
      ->type_name("DIR");
  experiment->add_option("--page", line.experiment.page, "also write the results as a Markdown page")
      ->type_name("FILE");
  experiment->add_flag("--quiet", line.experiment.quiet, "no progress lines");
}

ExitCode run_or_check(CommandLine& line, bool run) {
  line.options.scene = find_scene(line.scene);
  if (line.frames > 0) line.options.frames = line.frames;
  if (run) return run_scene(line.options);
  check_scene(line.options);
  return ExitCode::done;
}

ExitCode perform(const CLI::App& app, CommandLine& line) {
  if (app.got_subcommand("run") || app.got_subcommand("check"))
    return run_or_check(line, app.got_subcommand("run"));
  if (app.got_subcommand("list")) fmt::print("{}", list_of_scenes(bundled_folder()));
  if (app.got_subcommand("experiment")) run_experiments(line.experiment);
  if (app.got_subcommand("explain")) fmt::print("{}", line.markdown ? reference_page() : explain(line.pointer));
  if (app.got_subcommand("schema")) fmt::print("{}\n", scene_schema().dump(2));
  return ExitCode::done;
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

std::string unknown_command(const CLI::App& app, const std::string& word) {
  const std::vector<std::string> known = commands_of(app);
  const std::string near = nearest(word, known);
  return fmt::format("{} is no command (there are {}){}", in_quotes(word), fmt::join(known, ", "),
                     near.empty() ? "" : fmt::format(" did you mean {}?", near));
}

/// Names of files may hold anything, and an error is one line.
std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  return text;
}

/// A file that is opened first would otherwise take the number of a stream that the caller closed, and what is
/// printed would go into it.
void open_missing_streams() {
  int fd = ::open("/dev/null", O_RDWR);
  while (fd >= 0 && fd <= STDERR_FILENO) fd = ::open("/dev/null", O_RDWR);
  if (fd >= 0) ::close(fd);
}

int report(const std::string& message, ExitCode exit_code) {
  std::fputs(("wick: " + one_line(message) + "\n").c_str(), stderr);
  return code(exit_code);
}

}  // namespace

int main(int argc, char** argv) {
  open_missing_streams();
  CommandLine line;
  CLI::App app("burning sheets and their smoke", "wick");
  add_commands(app, line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0 && app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-')
      return report(unknown_command(app, argv[1]), ExitCode::command_line);
    if (error.get_exit_code() != 0 && app.get_subcommands().empty() && argc == 1)
      return report(
          fmt::format("a command is missing (there are {}; see wick --help)", fmt::join(commands_of(app), ", ")),
          ExitCode::command_line);
    if (error.get_exit_code() != 0)
      return report(error.what() + std::string(" (see wick --help)"), ExitCode::command_line);
    return app.exit(error);  // prints the help or the version that was asked for
  }
  try {
    const ExitCode done = perform(app, line);
    if (std::fflush(stdout) != 0 && !app.got_subcommand("run"))
      return report(fmt::format("cannot print the answer ({})", std::strerror(errno)), ExitCode::input_output);
    return done == ExitCode::checkpointed ? line.requeue_code : code(done);
  } catch (const Refusal& refusal) {
    return report(format_refusal(line.scene, refusal), refusal.code());
  } catch (const std::bad_alloc&) {
    return report("out of memory (the scene is too large for this machine) lower its resolutions",
                  ExitCode::refused);
  } catch (const std::system_error& error) {
    return report(error.what(), ExitCode::input_output);
  } catch (const std::exception& error) {
    return report(fmt::format("internal fault: {}", error.what()), ExitCode::internal_fault);
  } catch (...) {
    return report("internal fault: an unknown exception", ExitCode::internal_fault);
  }
}
