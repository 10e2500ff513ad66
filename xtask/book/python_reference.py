"""Writes the reference of the Python packages as Markdown, from signatures and docstrings.

    python python_reference.py PACKAGE_FOLDER [FOLDER_OF_ANOTHER...]

Reads the sources without importing them: what is not built can be documented all the same. Public is
what `__all__` of a module names, or without it every name without a leading underscore.
"""

import ast
import inspect
import re
import sys
from pathlib import Path

WIDEST = 88


def main(package):
    modules = {
        path.stem: ast.parse(path.read_text())
        for path in sorted(package.glob("*.py"))
        if path.stem == "__init__" or not path.stem.startswith("_")
    }
    private = {path.stem: path for path in package.glob("_[a-z]*.py")}
    for tree in modules.values():
        follow(tree, package.name, private)
    top = modules.pop("__init__")
    print(prose(ast.get_docstring(top)))
    print(f"\n## {package.name}")
    home = sources(top, package.name, modules)
    for name in names_in(top):
        if name in home:
            describe(home[name], f"{package.name}.")
    for stem, tree in modules.items():
        # What is used by its module's name; the rest stands above.
        public = [node for node in tree.body if is_public(node) and node is not home.get(node.name)]
        if "__all__" in assigned(tree):
            public = [node for node in public if node.name in names_in(tree)]
        if not public or (stem in opened(top, package.name) and stem not in names_in(top)):
            continue
        print(f"\n## {package.name}.{stem}\n")
        print(prose(ast.get_docstring(tree)))
        for node in public:
            describe(node, f"{package.name}.{stem}.")


def describe_beside(package):
    """A package of its own, by the names that it gives away."""
    tree, name = ast.parse((package / "__init__.py").read_text()), package.name
    print(f"\n## {name}\n")
    print(prose(ast.get_docstring(tree)))
    parts = {path.stem: ast.parse(path.read_text()) for path in package.glob("*.py")}
    found = sources(tree, name, parts)
    for public in names_in(tree):
        describe(found[public], f"{name}.")


def follow(tree, package, private):
    """Give a module what it takes from private ones and names as its own, or inherits."""
    own = set(names_in(tree)) if "__all__" in assigned(tree) else set()
    for node in list(tree.body):
        path = isinstance(node, ast.ImportFrom) and private.get(
            node.module.removeprefix(f"{package}.")
        )
        if not path:
            continue
        named = {alias.name for alias in node.names}
        parts = [part for part in ast.parse(path.read_text()).body if hasattr(part, "name")]
        tree.body += [part for part in parts if part.name in own & named]
        bases = {part.name: part for part in parts if part.name in named}
        for heir in tree.body:
            for base in getattr(heir, "bases", ()):
                heir.body += bases[base.id].body if ast.unparse(base) in bases else []


def sources(tree, package, modules):
    """Where the names come from that a package takes from its modules."""
    found = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module.startswith(f"{package}."):
            names = {alias.name for alias in node.names}
            own = modules.get(node.module.removeprefix(f"{package}."))
            # What a module has taken from another itself is looked for in all of them first.
            for module in [*modules.values(), own]:
                for part in module.body if module else ():
                    if isinstance(part, (ast.ClassDef, ast.FunctionDef)) and part.name in names:
                        found[part.name] = part
    return found


def opened(tree, package):
    """Modules that the package takes names from: what they keep is theirs."""
    imports = [node.module for node in tree.body if isinstance(node, ast.ImportFrom)]
    return {module.removeprefix(f"{package}.") for module in imports}


def assigned(tree):
    return {
        target.id: node.value
        for node in tree.body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }


def names_in(tree):
    return sorted(ast.literal_eval(assigned(tree)["__all__"]), key=str.lower)


def is_public(node):
    return isinstance(node, (ast.ClassDef, ast.FunctionDef)) and not node.name.startswith("_")


def describe(node, prefix):
    if isinstance(node, ast.FunctionDef):
        print(f"\n### {prefix}{node.name}\n")
        print(f"```text\n{signature(node)}\n```\n")
        print(prose(ast.get_docstring(node)))
        return
    print(f"\n### {prefix}{node.name}\n")
    print(prose(ast.get_docstring(node)))
    fields, methods = [], []
    for member, after in zip(node.body, [*node.body[1:], None], strict=True):
        if isinstance(member, ast.FunctionDef) and not member.name.startswith("_"):
            text = ast.get_docstring(member) or ""
            # A table has no room for an example.
            kind = fields if is_property(member) and ">>>" not in text else methods
            kind.append((member.name, member.returns, text, member))
        elif (
            isinstance(member, ast.AnnAssign)
            and not member.target.id.startswith("_")
            and isinstance(after, ast.Expr)
            and isinstance(after.value, ast.Constant)
        ):
            fields.append((member.target.id, member.annotation, after.value.value, None))
    if fields:
        print("\n| | type | |\n|---|---|---|")
    for name, of, text, _ in fields:
        cells = f"`{name}`", f"`{ast.unparse(of)}`", " ".join(prose(text).split())
        print("".join(f"| {cell.replace('|', chr(92) + '|')} " for cell in cells) + "|")
    for name, _, text, method in methods:
        print(f"\n#### {node.name}.{name}\n\n```text\n{signature(method)}\n```\n")
        print(prose(text))


def is_property(node):
    return any("property" in ast.unparse(decorator) for decorator in node.decorator_list)


def signature(node):
    returns = ast.unparse(node.returns) if node.returns else "None"
    if is_property(node):
        return f"{node.name}: {returns}"
    arguments = node.args
    arguments.args = [a for a in arguments.args if a.arg not in ("self", "cls")]
    # With the spaces that belong around the default of an annotated argument.
    listed = re.sub(r"(: [^=,]+(?:\[[^=]*\])?[^=,]*)=", r"\1 = ", ast.unparse(arguments))
    line = f"{node.name}({listed}) -> {returns}"
    if len(line) <= WIDEST:
        return line
    # Commas between arguments, not those inside brackets.
    parts = re.split(r", (?![^\[(]*[\])])", listed)
    return f"{node.name}(\n" + "".join(f"    {part},\n" for part in parts) + f") -> {returns}"


def prose(text):
    """Docstrings as Markdown: examples in blocks, code in single backquotes, sections as lists."""
    lines, block = [], []
    source = [*inspect.cleandoc(text or "").splitlines(), ""]
    for line, below in zip(source, [*source[1:], ""], strict=True):
        if line.lstrip().startswith(">>>") or (block and line.strip()):
            block.append(line)
            continue
        if block:
            lines += ["```pycon", *inspect.cleandoc("\n".join(block)).splitlines(), "```"]
            block = []
        line = re.sub(r":\w+:`~?\.?([^`]+)`", r"`\1`", line).replace("``", "`")
        if re.fullmatch(r"-{3,}", below):
            lines += [f"**{line}**", ""]
        elif re.fullmatch(r"-{3,}", line):
            continue
        elif line and not line.startswith(" ") and below.startswith("    "):
            # What is described below it, indented.
            lines.append(f"- `{line}`:")
        elif line.startswith("    "):
            lines[-1] += " " + line.strip()
        else:
            lines.append(line)
    return "\n".join(lines).strip()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
    for beside in sys.argv[2:]:
        describe_beside(Path(beside))
