#!/usr/bin/env python3
"""Names members of Eigen types that have no initialiser: `eigen_members.py FOLDER...`.

Eigen leaves new matrices as the memory was, and `{}` is no initialiser for them: `std::array<Eigen::Vector2f, 4> a{};`
holds garbage as well. Such a member needs `= Eigen::Vector2f::Zero()` or the like. Matrices whose size is known only at
run time begin empty and are let pass. `--self-test` tries the finder itself. Status 1 if anything was found.
"""
import pathlib
import re
import sys

FIXED = re.compile(
    r"Eigen::(?:(?:Vector|RowVector|Matrix|Array)[1-9][1-9]?[a-z]+\b|(?:Matrix|Array|Vector|RowVector)<|Quaternion|AngleAxis"
    r"|Transform|Affine|Isometry|Hyperplane|ParametrizedLine|Translation|Rotation2D)")
# What owns its elements and has none at first, refers to others', or is no object at all.
HARMLESS = re.compile(
    r"^(?:static|using|typedef|friend|template|return|constexpr|extern)\b|std::(?:vector|optional|span|function|unique_ptr"
    r"|shared_ptr|map|deque|variant)<|Eigen::(?:Map|Ref)<|FixedVector<|[&*]\s*\w+\s*$|Dynamic")


def without_comments(text):
    """The same text with comments and quoted text blank; lines keep their numbers."""
    pattern = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S)
    return pattern.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def aliases_in(texts):
    """Names that stand for a fixed-size type of Eigen's, over all files and with what refers to another name."""
    uses = [(name, type_) for text in texts for name, type_ in re.findall(r"using\s+(\w+)\s*=\s*([^;]+);", text)]
    names = set()
    while True:
        more = {name for name, type_ in uses if is_fixed(type_, names)} - names
        if not more:
            return names
        names |= more


def is_fixed(type_, aliases):
    if HARMLESS.search(type_):
        return False
    return bool(FIXED.search(type_)) or any(re.search(rf"(?<![\w.]){alias}\b(?!::)", type_) for alias in aliases)


def members_in(text):
    """(line, declaration) of everything that ends with a semicolon right inside a class."""
    scopes, statement, line, began, nesting = [], "", 1, 1, 0
    for char in text:
        if char == "\n":
            line += 1
        if char in "(<" and char == "(":
            nesting += 1
        if char == ")":
            nesting -= 1
        if char == "{" and nesting == 0:
            is_class = re.search(r"\b(?:struct|class|union)\b[^()=;]*$", statement) and "enum" not in statement
            in_class = scopes and scopes[-1] == "class"
            # A member's own braces are a part of its declaration.
            looks_like_member = in_class and not is_class and "(" not in statement and "=" not in statement.replace("==", "")
            if in_class and not is_class and (looks_like_member or re.search(r"[^=!<>]=[^=]*$", statement)):
                scopes.append("initialiser")
                statement += char
                continue
            scopes.append("class" if is_class else "other")
            statement = ""
            continue
        if char == "}" and nesting == 0 and scopes:
            if scopes.pop() == "initialiser":
                statement += char
            else:
                statement = ""
            continue
        if char == ";" and nesting == 0:
            if scopes and scopes[-1] == "class":
                yield began, " ".join(statement.split())
            statement = ""
            continue
        if char == ":" and re.search(r"\b(?:public|private|protected)$", statement.strip()):
            statement = ""
            continue
        if not statement.strip():
            statement, began = "", line
        statement += char


def uninitialised(text, aliases):
    for line, declaration in members_in(without_comments(text)):
        type_ = re.split(r"[={(]", declaration)[0]
        if not is_fixed(type_.strip(), aliases):
            continue
        if re.search(r"=\s*\S|\{\s*[^\s}]", declaration) or "(" in declaration:
            continue
        yield line, declaration


SELF_TEST = """
using Six = Eigen::Matrix<double, 6, 1>;
struct Bad {
  int fine = 0;
  Eigen::Vector2d plain;  // bad
  std::array<Eigen::Vector2f, 4> braces{};  // bad
  Six alias;  // bad
  Eigen::Vector3f two, names;  // bad
 private:
  Eigen::Matrix<float, 2, 3> after_label_;  // bad
  struct Inner { Eigen::Quaterniond inner; };  // bad
};
struct Good {
  Eigen::Vector2d plain = Eigen::Vector2d::Zero();
  Eigen::Vector2d braces{1, 2};
  Six alias = Six::Zero();
  Eigen::MatrixXd sized;
  std::vector<Eigen::Vector2d> many;
  std::optional<Eigen::Vector2d> maybe;
  const Eigen::Vector2d& borrowed;
  Eigen::Matrix<double, Eigen::Dynamic, 6> rows;
  static Eigen::Vector2d Make(int x);
  Eigen::Vector2d Get() const { Eigen::Vector2d local; return local; }
  std::vector<Six> list = {};
};
void Function() { Eigen::Vector2d local; }
"""


def self_test():
    expected = [number for number, line in enumerate(SELF_TEST.split("\n"), 1) if "// bad" in line]
    found = [line for line, _ in uninitialised(SELF_TEST, aliases_in([without_comments(SELF_TEST)]))]
    if found != expected:
        sys.exit(f"self-test: found lines {found}, expected {expected}")


def main():
    self_test()
    files = [file for folder in sys.argv[1:] for file in sorted(pathlib.Path(folder).rglob("*")) if file.suffix in (".h", ".cpp")]
    if not files:
        sys.exit("eigen_members.py: no source files in " + " ".join(sys.argv[1:]))
    texts = {file: file.read_text() for file in files}
    aliases = aliases_in(map(without_comments, texts.values()))
    bad = [f"{file}:{line}: {what}: has no initialiser" for file, text in texts.items() for line, what in uninitialised(text, aliases)]
    print("\n".join(bad) if bad else f"{len(files)} files: every member of an Eigen type has an initialiser")
    sys.exit(1 if bad else 0)


main()
