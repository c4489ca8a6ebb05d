module bw_beam_par
  !! `&beam`: a beam of one or several pieces, from the root outwards, uniform or tapering.
  use bw_beam_piece, only: area_of, beam_piece, fibre_of, mass_moments, piece_mass, second_moment_of, section_between
  use bw_input_name, only: input_group, input_name, positive, reals_input, text_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp, qp
  use bw_missing, only: is_missing
  use bw_scene_messages, only: message_list, round_product
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: area_of, beam_mass, beam_piece, beam_text, build_beam, check_beam, has_fibre, piece_mass, pieces_of_beam, &
    second_moment_of, section_at, sections_of_beam

  type, extends(beam_piece), public :: beam_par
    !! The whole beam. Its length is the sum of all pieces; its other values are those of the piece at the root.
    type(beam_piece), allocatable :: pieces(:)
      !! from the root outwards, with the sections of their inner ends; unallocated: a uniform beam, (n)
    type(beam_piece), allocatable :: outer(:)    !! sections of the outer ends of a tapering beam, else unallocated, (n)
  end type beam_par

  type(input_group), parameter, public :: beam_group = input_group( &
    'beam', required=.true., unless='record', absent='an error, unless a `&record` is analysed for frequencies alone', &
    physics='A straight, slender beam of linear elastic material that bends in one plane: rho A v_tt + (E I v_xx)_xx = '// &
    'load, with v the deflection and x from the root to the tip. The example is a tube, given by area and second moment, '// &
    'with the distance of the fibre at which stresses are wanted.', &
    example='&beam length = 2, area = 6.4e-4, second_moment = 1.3e-7, density = 2700, youngs_modulus = 70e9, extreme_fibre '// &
    '= 0.02 /', &
    rules='Give `diameter` for a solid circle, `width` and `height` for a solid rectangle that bends along its height, or '// &
    '`area` and `second_moment` for any other section; or `mass_per_length` and `bending_stiffness` in place of material and '// &
    'section. `length` says how many uniform pieces the beam has, from the root outwards, as `length = 0.3, 0.7`; every other '// &
    'name has one value for all pieces, or one for each. With `taper = ''linear''` it has one value, or one for each of the n '// &
    '+ 1 stations at the ends of pieces, from the root to the tip, and is linear between stations; areas and second moments of '// &
    'circles and rectangles follow from their linear sides. Stresses refer to `extreme_fibre`, else to half of `diameter` or '// &
    '`height`. A sweep varies one value of a list by its number, as `beam%length(2)`.')

  integer, parameter :: most_pieces = 1000, most_stations = most_pieces + 1
  character(*), parameter :: lumped = 'mass_per_length bending_stiffness'
  character(*), parameter :: by_section = 'density youngs_modulus diameter width height area second_moment'

  type(input_name), parameter, public :: beam_names(*) = [ &
    input_name('beam', 'length', reals_input, 'm', positive, required=.true., swept=.true., most=most_pieces, along='piece', &
               meaning='length from the root to the tip, or of each piece'), &
    input_name('beam', 'density', reals_input, 'kg m-3', positive, required=.true., unless=lumped, swept=.true., &
               most=most_stations, along='piece', excludes=lumped, meaning='mass density of the material'), &
    input_name('beam', 'youngs_modulus', reals_input, 'Pa', positive, required=.true., unless=lumped, swept=.true., &
               most=most_stations, along='piece', excludes=lumped, meaning='Young''s modulus E'), &
    input_name('beam', 'diameter', reals_input, 'm', positive, swept=.true., most=most_stations, along='piece', &
               excludes='width height area second_moment '//lumped, meaning='diameter of a solid circular section'), &
    input_name('beam', 'width', reals_input, 'm', positive, swept=.true., most=most_stations, along='piece', &
               excludes='diameter area second_moment '//lumped, meaning='width of a solid rectangular section'), &
    input_name('beam', 'height', reals_input, 'm', positive, swept=.true., most=most_stations, along='piece', &
               excludes='diameter area second_moment '//lumped, &
               meaning='height of a solid rectangle, along which it bends'), &
    input_name('beam', 'area', reals_input, 'm2', positive, swept=.true., most=most_stations, along='piece', &
               excludes='diameter width height '//lumped, meaning='area of the section'), &
    input_name('beam', 'second_moment', reals_input, 'm4', positive, swept=.true., most=most_stations, along='piece', &
               excludes='diameter width height '//lumped, &
               meaning='second moment of area I, for the bending stiffness E I'), &
    input_name('beam', 'mass_per_length', reals_input, 'kg m-1', positive, swept=.true., most=most_stations, along='piece', &
               excludes=by_section, meaning='mass per length rho A, in place of material and section'), &
    input_name('beam', 'bending_stiffness', reals_input, 'N m2', positive, swept=.true., most=most_stations, along='piece', &
               excludes=by_section, meaning='bending stiffness E I, in place of material and section'), &
    input_name('beam', 'extreme_fibre', reals_input, 'm', positive, swept=.true., most=most_stations, along='piece', &
               meaning='distance of the outermost fibre from the axis'), &
    input_name('beam', 'taper', text_input, default='''none''', words='none linear', &
               meaning='how sections vary between stations')]

  character(*), parameter :: sections = 'diameter, or width and height, or area and second_moment, or mass_per_length and '// &
                             'bending_stiffness'

contains

  pure subroutine check_beam(beam, messages)
    !! Check that the section is complete: a diameter, both names of another section, or both names that replace material and
    !! section; and that lists have matching lengths.
    type(group_values), intent(in) :: beam
    type(message_list), intent(inout) :: messages
    call check_counts(beam, messages)
    if (beam%given('diameter')) return
    if (beam%given('width') .or. beam%given('height')) then
      call check_pair(beam, 'width', 'height', ', or diameter alone', messages)
    else if (beam%given('area') .or. beam%given('second_moment')) then
      call check_pair(beam, 'area', 'second_moment', ', or diameter alone', messages)
    else if (beam%given('mass_per_length') .or. beam%given('bending_stiffness')) then
      call check_pair(beam, 'mass_per_length', 'bending_stiffness', ', or density, youngs_modulus and a section', messages)
    else
      call messages%add(0, 'beam%diameter', 'is missing; accepted: '//sections)
    end if
  end subroutine check_beam

  pure subroutine check_pair(beam, one, other, otherwise, messages)
    !! Report if only one of two names is given.
    type(group_values), intent(in) :: beam
    character(*), intent(in) :: one, other
    character(*), intent(in) :: otherwise      !! what else is accepted
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: absent
    if (beam%given(one) .and. beam%given(other)) return
    absent = one
    if (beam%given(one)) absent = other
    call messages%add(0, 'beam%'//absent, 'is missing; accepted: '//one//' and '//other//otherwise)
  end subroutine check_pair

  pure subroutine check_counts(beam, messages)
    !! Check counts: `length` sets the number of pieces; another name has one value for all, one per piece, or one per end.
    type(group_values), intent(in) :: beam
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: hint, each
    integer :: v, n, pieces, most
    pieces = beam%count_of('length')
    most = pieces
    each = repeat(', or one for each piece', merge(1, 0, pieces > 1))
    if (tapers(beam)) then
      most = pieces + 1
      each = ', or one for each of the '//text_of(most)//' stations at the ends of pieces'
    else
      each = each//'; or '//text_of(pieces + 1)//', one for each station, with taper = ''linear'''
    end if
    do v = 1, size(beam%values)
      associate (value => beam%values(v))
        n = beam%count_of(value%name)
        if (value%name == 'length' .or. pieces == 0 .or. n < 2 .or. n == most) cycle
        hint = ''
        if (all(value%numbers == value%numbers(1))) hint = ' (in a namelist '//text_of(n)//'*'//shortest(value%numbers(1), 15)// &
          ' is the value '//text_of(n)//' times, not a product)'
        call messages%add(value%line, 'beam%'//trim(value%name), 'has '//text_of(n)//' values'//hint//', and length has '// &
                          text_of(pieces)//', which sets the number of pieces; accepted: one value'//each)
      end associate
    end do
  end subroutine check_counts

  pure subroutine build_beam(values, beam, messages)
    !! Build the beam from checked values; derive what is not given.
    type(group_values), intent(in) :: values
    type(beam_par), intent(out) :: beam
    type(message_list), intent(inout) :: messages
    integer :: count, i
    logical :: varies
    count = values%count_of('length')
    varies = .false.
    if (tapers(values)) varies = any([(values%count_of(values%values(i)%name), i=1, size(values%values))] > 1 &
                                     .and. values%values%name /= 'length')
    call build_piece(values, 1, 1, beam%beam_piece, messages)
    if (count == 1 .and. .not. varies) return
    allocate (beam%pieces(count))
    beam%pieces(1) = beam%beam_piece
    do i = 2, count
      call build_piece(values, i, i, beam%pieces(i), messages)
    end do
    if (varies) then
      allocate (beam%outer(count))
      do i = 1, count
        call build_piece(values, i, i + 1, beam%outer(i), messages)
      end do
    end if
    call round_product(sum(real(beam%pieces%length, qp)), beam%length, values%line_of('length'), 'beam%length', &
                        'the length of all pieces', messages)
  end subroutine build_beam

  pure logical function tapers(beam)
    !! Return whether sections are given at stations.
    type(group_values), intent(in) :: beam
    tapers = .false.
    if (beam%known('taper')) tapers = beam%text('taper') == 'linear'
  end function tapers

  pure subroutine build_piece(values, i, s, piece, messages)
    !! Build piece i with its section s from checked values.
    type(group_values), intent(in) :: values
    integer, intent(in) :: i, s
    type(beam_piece), intent(out) :: piece
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: name, a, b
    piece%length = values%number_at('length', i)
    piece%density = values%number_at('density', s)
    piece%youngs_modulus = values%number_at('youngs_modulus', s)
    piece%round = values%given('diameter')
    if (values%given('extreme_fibre')) piece%extreme_fibre = values%number_at('extreme_fibre', s)
    if (piece%round) then
      piece%diameter = values%number_at('diameter', s)
      name = 'diameter'
      a = 'pi/4 D^2'
      b = 'pi/64 D^4'
    else if (values%given('width')) then
      piece%width = values%number_at('width', s)
      piece%height = values%number_at('height', s)
      name = 'height'
      a = 'w h'
      b = 'w h^3/12'
    else if (values%given('mass_per_length')) then
      piece%is_lumped = .true.
      piece%density = values%number_at('mass_per_length', s)
      piece%youngs_modulus = values%number_at('bending_stiffness', s)
      piece%area = 1.0_dp
      piece%second_moment = 1.0_dp
      return
    else
      piece%area = values%number_at('area', s)
      piece%second_moment = values%number_at('second_moment', s)
      return
    end if
    call round_product(area_of(piece), piece%area, values%line_of(name), 'beam%'//name, 'the area '//a, messages)
    call round_product(second_moment_of(piece), piece%second_moment, values%line_of(name), 'beam%'//name, &
                        'the second moment of area '//b, messages)
  end subroutine build_piece

  elemental real(qp) function beam_mass(beam)
    !! Return m_i [kg], the mass of all pieces together.
    type(beam_par), intent(in) :: beam
    real(qp) :: moments(2)
    integer :: i
    if (allocated(beam%outer)) then
      beam_mass = 0.0_qp
      do i = 1, size(beam%pieces)
        moments = mass_moments(beam%pieces(i), beam%outer(i))
        beam_mass = beam_mass + moments(1)
      end do
    else if (allocated(beam%pieces)) then
      beam_mass = sum(piece_mass(beam%pieces))
    else
      beam_mass = piece_mass(beam%beam_piece)
    end if
  end function beam_mass

  pure function pieces_of_beam(beam) result(pieces)
    !! Return all pieces; a uniform beam is one piece.
    type(beam_par), intent(in) :: beam
    type(beam_piece), allocatable :: pieces(:)
    if (allocated(beam%pieces)) then
      pieces = beam%pieces
    else
      pieces = [beam%beam_piece]
    end if
  end function pieces_of_beam

  pure function sections_of_beam(beam) result(sections)
    !! Return the section of every piece, of tapering ones at both ends.
    type(beam_par), intent(in) :: beam
    type(beam_piece), allocatable :: sections(:)
    sections = pieces_of_beam(beam)
    if (allocated(beam%outer)) sections = [sections, beam%outer]
  end function sections_of_beam

  pure type(beam_piece) function section_at(beam, xi) result(section)
    !! Return the section at a place; at a joint, that of the inner piece.
    type(beam_par), intent(in) :: beam
    real(dp), intent(in) :: xi                 !! 0 ≤ ξ ≤ 1
    real(qp) :: inner, place
    integer :: i
    section = beam%beam_piece
    if (.not. allocated(beam%pieces)) return
    place = xi*sum(real(beam%pieces%length, qp))
    inner = 0.0_qp
    do i = 1, size(beam%pieces) - 1
      if (place <= (inner + beam%pieces(i)%length)*(1 + 8*epsilon(xi))) exit
      inner = inner + beam%pieces(i)%length
    end do
    section = beam%pieces(i)
    if (allocated(beam%outer)) section = section_between(section, beam%outer(i), &
                                                         real(min(1.0_qp, (place - inner)/section%length), dp))
  end function section_at

  pure logical function has_fibre(beam)
    !! Return whether stresses follow from moments.
    type(beam_par), intent(in) :: beam
    has_fibre = .not. (beam%is_lumped .or. is_missing(fibre_of(beam%beam_piece)))
  end function has_fibre

  pure function beam_text(beam) result(text)
    !! Return the part of a report on pieces: ` in 2 pieces (0.3, 0.7 m)`, ` in 1 tapering piece`, or nothing if uniform.
    type(beam_par), intent(in) :: beam
    character(:), allocatable :: text
    integer, parameter :: most = 5
    integer :: i
    text = ''
    if (.not. allocated(beam%pieces)) return
    text = ' in '//text_of(size(beam%pieces))//repeat(' tapering', merge(1, 0, allocated(beam%outer)))//' piece'// &
      repeat('s', merge(1, 0, size(beam%pieces) > 1))
    if (size(beam%pieces) > most .or. size(beam%pieces) == 1) return
    text = text//' ('
    do i = 1, size(beam%pieces)
      if (i > 1) text = text//', '
      text = text//shortest(beam%pieces(i)%length, 6)
    end do
    text = text//' m)'
  end function beam_text

end module bw_beam_par
