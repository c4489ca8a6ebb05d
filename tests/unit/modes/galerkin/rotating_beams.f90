module rotating_beams
  !! Uniform beams of one piece for tests: clamped at the root, with a body at the tip, lengths in l, times in l²/h, masses in m_i.
  use bw_double_double, only: to_dd, operator(*)
  use bw_kinds, only: dp
  use bw_piece_beam, only: piece_beam
  use bw_strain_modes, only: strain_modes
  use bw_strain_set, only: strain_set
  use bw_varying_beam, only: under_tension, varying_beam, without_tension
  use reference_table, only: column
  implicit none (type, external)
  private
  public :: beam_of_row, beam_of_table, first_modes, one_piece, stiffened, unstiffened

  type, public :: reference_row
    !! One row of a table of modes.
    type(varying_beam) :: beam
    integer :: k = 1                             !! mode
    real(dp) :: square = 0.0_dp, spin = 0.0_dp   !! β² and Ω²
    real(dp) :: middle = 0.0_dp, mean = 0.0_dp, tip = 0.0_dp   !! what else the table has, 0 for what it has not
    real(dp) :: gamma = 0.0_dp
    logical :: is_pulled = .false.               !! by tension
  end type reference_row

contains

  type(piece_beam) function one_piece(omega, gamma, in_plane, compliance, rotary, inertia) result(beam)
    real(dp), intent(in) :: omega, gamma
    logical, intent(in) :: in_plane
    real(dp), intent(in), optional :: compliance, rotary, inertia      !! s², r² and J; absent: none
    allocate (beam%piece(1), beam%joint(1))
    beam%joint(1)%mass = to_dd(gamma)
    beam%spin_squared = to_dd(omega)*to_dd(omega)
    beam%in_plane = in_plane
    if (present(compliance)) beam%piece(1)%compliance = to_dd(compliance)
    if (present(rotary)) beam%piece(1)%rotary = to_dd(rotary)
    if (present(inertia)) beam%joint(1)%inertia = to_dd(inertia)
  end function one_piece

  type(varying_beam) function stiffened(omega, hub, gamma, in_plane, compliance, rotary, inertia)
    real(dp), intent(in) :: omega, hub, gamma
    logical, intent(in) :: in_plane
    real(dp), intent(in), optional :: compliance, rotary, inertia
    stiffened = under_tension(one_piece(omega, gamma, in_plane, compliance, rotary, inertia), hub)
  end function stiffened

  type(varying_beam) function unstiffened(omega, gamma, in_plane, compliance, rotary, inertia)
    real(dp), intent(in) :: omega, gamma
    logical, intent(in) :: in_plane
    real(dp), intent(in), optional :: compliance, rotary, inertia
    unstiffened = without_tension(one_piece(omega, gamma, in_plane, compliance, rotary, inertia))
  end function unstiffened

  type(strain_set) function first_modes(beam, count) result(set)
    type(varying_beam), intent(in) :: beam
    integer, intent(in) :: count
    call strain_modes(beam, count, size(beam%beam%piece), set)
  end function first_modes

  type(reference_row) function beam_of_row(file, row) result(found)
    !! A row of tension_modes.txt, shear_modes.txt or heavy_modes.txt.
    character(*), intent(in) :: file
    integer, intent(in) :: row
    type(piece_beam) :: beam
    found%gamma = at('gamma')
    found%is_pulled = file == 'tension_modes.txt'
    if (file == 'heavy_modes.txt') found%is_pulled = at('tension') > 0.0_dp
    found%k = nint(at('k'))
    found%square = at('beta_squared')
    found%spin = at('omega')**2
    beam = one_piece(at('omega'), found%gamma, at('in_plane') > 0.0_dp, at('compliance'), at('rotary'), at('inertia'))
    found%middle = at('midpoint')
    if (found%is_pulled) then
      found%beam = under_tension(beam, at('hub'))
    else
      found%beam = without_tension(beam)
    end if
    if (file == 'tension_modes.txt') found%mean = at('mean_square')
    if (file == 'heavy_modes.txt') found%tip = at('tip')
  contains
    real(dp) function at(name)
      character(*), intent(in) :: name
      real(dp), allocatable :: values(:)
      values = real(column(file, name), dp)
      at = values(row)
    end function at
  end function beam_of_row

  type(piece_beam) function beam_of_table(table, number) result(beam)
    !! A beam of piece_beams.txt, soft_beams.txt or tension_pieces.txt.
    character(*), intent(in) :: table
    integer, intent(in) :: number
    real(dp), allocatable :: value(:)
    logical, allocatable :: mine(:)
    mine = nint(of('beam')) == number
    allocate (beam%piece(count(mine)), beam%joint(count(mine)))
    beam%piece%length = to_dd(pack(of('length'), mine))
    beam%piece%stiffness = to_dd(pack(of('stiffness'), mine))
    beam%piece%mass = to_dd(pack(of('mass'), mine))
    beam%piece%compliance = to_dd(pack(of('compliance'), mine))
    beam%piece%rotary = to_dd(pack(of('rotary'), mine))
    beam%joint%mass = to_dd(pack(of('body_mass'), mine))
    beam%joint%inertia = to_dd(pack(of('body_inertia'), mine))
    beam%joint%stiffness = to_dd(pack(of('spring'), mine))
    beam%joint%turning_stiffness = to_dd(pack(of('turning_spring'), mine))
    value = pack(of('root_spring'), mine)
    beam%root%holds_deflection = value(1) < 0
    beam%root%stiffness = to_dd(max(0.0_dp, value(1)))
    value = pack(of('root_turning'), mine)
    beam%root%holds_turning = value(1) < 0
    beam%root%turning_stiffness = to_dd(max(0.0_dp, value(1)))
    value = pack(of('omega'), mine)
    beam%spin_squared = to_dd(value(1))*to_dd(value(1))
    value = pack(of('in_plane'), mine)
    beam%in_plane = value(1) > 0
  contains
    function of(name) result(values)
      character(*), intent(in) :: name
      real(dp), allocatable :: values(:)
      values = real(column(table, name), dp)
    end function of
  end function beam_of_table

end module rotating_beams
