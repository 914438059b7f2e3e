"""PLC projects of TwinCAT, as files."""

from pathlib import Path

HEAD = '<?xml version="1.0" encoding="utf-8"?>\n'
PROJECT = (
    HEAD
    + """<Project DefaultTargets="Build" xmlns="http://schemas.microsoft.com/developer/msbuild/2003">
  <PropertyGroup><Name>{name}</Name><Title>{title}</Title></PropertyGroup>
  <ItemGroup>{files}</ItemGroup>
  <ItemGroup>{references}</ItemGroup>
</Project>
"""
)
TCUNIT = """
<PlaceholderReference Include="TcUnit"><Namespace>TcUnit</Namespace>
  <Parameters><Parameter ListName="GVL_PARAM_TCUNIT">
    <Key>LOGEXTENDEDRESULTS</Key><Value>FALSE</Value>
  </Parameter></Parameters>
</PlaceholderReference>
"""


def project(folder: Path, files: dict[str, str], *references: str, title: str = "") -> Path:
    """Write a project, whose file names may have folders in them as TwinCAT writes them."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        path = folder / name.replace("\\", "/")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    included = "".join(f'<Compile Include="{name}"><SubType>Code</SubType></Compile>' for name in files)
    path = folder / f"{folder.name}.plcproj"
    path.write_text(
        PROJECT.format(name=folder.name, title=title, files=included, references="".join((TCUNIT, *references)))
    )
    return path
